"""What the documentation shows runs: every Python block, every docstring example, every link."""

import doctest
import importlib
import pkgutil
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / name for name in ("README.md", "SECURITY.md", "CONTRIBUTING.md", "CHANGELOG.md")]
PAGES += sorted((ROOT / "docs").rglob("*.md"))
PACKAGES = ("barrier_certificates", "rps_compat", "posflock_robotarium")


def python_blocks(page: Path) -> list[str]:
    """Return the fenced Python blocks of a page, in order."""
    return re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S)


def modules() -> list[str]:
    found = []
    for name in PACKAGES:
        package = importlib.import_module(name)
        found += [m.name for m in pkgutil.walk_packages(package.__path__, f"{name}.")]
    return [m for m in found if not m.endswith("__main__")]


@pytest.mark.usefixtures("shared_trials")
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_examples_of_a_page_run_in_order(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    namespace = {"__name__": "__page__"}
    for number, block in enumerate(python_blocks(page), 1):
        exec(compile(block, f"{page.name}, block {number}", "exec"), namespace)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_within_the_project_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", page.read_text(encoding="utf-8")):
        if "://" not in target:
            assert (page.parent / target).exists(), target


@pytest.mark.parametrize("name", modules())
def test_docstring_examples_are_true(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = doctest.testmod(
        importlib.import_module(name), optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    )
    assert result.failed == 0


def test_the_tree_that_is_drawn_is_the_tree_there_is():
    page = (ROOT / "docs/explanations/architecture.md").read_text(encoding="utf-8")
    folders: list[str] = []
    drawn = set()
    for line in page.split("```")[1].strip().splitlines():
        names = re.match(r"(?:\w+(?:/|\.py)(?:, )?)+", line.strip())
        assert names, line
        depth = (len(line) - len(line.lstrip())) // 4
        for name in names[0].split(", "):
            folders[depth:] = [name]
            drawn.add("/".join(part.strip("/") for part in folders))
    assert all((ROOT / path).exists() for path in drawn), drawn
    for package in PACKAGES:
        inside = {path.parent.name for path in (ROOT / package).glob("*/__init__.py")}
        assert {f"{package}/{name}" for name in inside} <= drawn
    for path in re.findall(r"`([\w/]+/[\w.]+)`", page):
        assert (ROOT / path).exists(), path
