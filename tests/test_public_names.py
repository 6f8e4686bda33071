"""What is public is declared, documented, and all that the documentation uses."""

import ast
import re

import pytest
from test_documentation import PAGES, ROOT, python_blocks

from tools.documentation.api_pages import FOLDER, api_pages
from tools.documentation.public_names import PACKAGES, public_surface


@pytest.fixture(scope="module")
def surface():
    return public_surface()


@pytest.fixture(scope="module")
def pages(surface):
    return api_pages(surface)


def test_every_public_name_has_an_entry_in_the_api_reference(surface, pages):
    assert len(surface.documented) > 500
    entries = re.findall(r"^\.\. (?:auto\w+|py:type):: (\S+)\n", "".join(pages.values()), re.M)
    assert len(entries) == len(set(entries))
    assert set(entries) == set(surface.documented) | set(surface.modules)
    for name in surface.names:
        assert surface.entries[name.path] in surface.documented, name.path


def test_every_page_of_the_api_reference_is_reached_from_its_index(pages):
    reached, waiting = set(), [f"{FOLDER}/index.rst"]
    while waiting:
        page = waiting.pop()
        reached.add(page)
        waiting += [
            f"{FOLDER}/{path}.rst" for path in re.findall(r"^   \S+ <(.+)>$", pages[page], re.M)
        ]
    assert reached == set(pages)


def test_every_public_class_and_function_tells_what_it_is_for(surface):
    untold = [
        name.path
        for name in surface.documented.values()
        if name.kind in ("class", "exception", "function") and not name.value.__doc__
    ]
    assert untold == []


def test_what_the_documentation_imports_is_public(surface):
    listed = {name.path for name in surface.names} | set(surface.modules)
    for page in PAGES:
        # Who adds a check to the project uses what is inside.
        for block in python_blocks(page) if page.name != "CONTRIBUTING.md" else ():
            for node in ast.walk(ast.parse(block)):
                if isinstance(node, ast.ImportFrom) and node.module.partition(".")[0] in PACKAGES:
                    for name in node.names:
                        assert f"{node.module}.{name.name}" in listed, page.name


def test_the_index_names_every_page():
    index = (ROOT / "docs/index.md").read_text(encoding="utf-8")
    linked = {(ROOT / "docs" / target).resolve() for target in re.findall(r"\]\(([^)#]+)", index)}
    assert set((ROOT / "docs").rglob("*.md")) - {ROOT / "docs/index.md"} <= linked
