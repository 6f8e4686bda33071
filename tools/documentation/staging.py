"""All pages in one folder, as Sphinx takes them: from `docs/`, beside it, and from docstrings.

The index is a page like any other, with lists of links under headings. On the site the same links
are the navigation: a section each, in the order of the page.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from tools.documentation.api_pages import api_pages
from tools.documentation.command_pages import command_page
from tools.documentation.page_figures import with_figures
from tools.documentation.public_names import public_surface
from tools.documentation.repository_links import BESIDE, RepositoryLinks

ROOT = Path(__file__).resolve().parents[2]
PICTURES = {".png", ".svg"}
#: A link of the index: what it is called there, and where it leads.
TITLED = re.compile(r"\[([^]]+)\]\(([^)\s]+)\)")
#: Pages that only the site has, by the heading of the index under which they belong.
MADE = {
    "Reference": [
        "- [API reference](reference/api/index.rst): every public name.",
        "- [Commands](reference/commands.md): the help of every command.",
    ]
}


def stage(folder: Path) -> None:
    """Lay all pages out, anew; pictures that examples draw are drawn.

    Parameters
    ----------
    folder : Path
        Emptied first.
    """
    shutil.rmtree(folder, ignore_errors=True)
    docs = ROOT / "docs"
    links = RepositoryLinks(ROOT)
    for file in sorted([*docs.rglob("*.md"), *(ROOT / name for name in BESIDE)]):
        path = file.relative_to(ROOT).as_posix()
        place = folder / links.place_of(path)
        text = file.read_text(encoding="utf-8")
        place.parent.mkdir(parents=True, exist_ok=True)
        text = links.rewritten(with_figures(text, place), path)
        place.write_text(with_navigation(text) if path == "docs/index.md" else text, "utf-8")
    for file in docs.rglob("*"):
        if file.suffix in PICTURES:
            place = folder / file.relative_to(docs)
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, place)
    made = links.source_pages() | api_pages(public_surface()) | command_page()
    for name, text in made.items():
        place = folder / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8")


def with_navigation(index: str) -> str:
    """Return the index with its links as Sphinx's navigation, a part for each heading.

    Parameters
    ----------
    index : str
        The page, with its links as they are on the site.
    """
    for heading, items in MADE.items():
        index = index.replace(f"## {heading}\n\n", "\n".join([f"## {heading}\n", *items, ""]), 1)
    parts = re.split(r"^## (.+)\n", index, flags=re.M)[1:]
    trees = []
    for heading, text in zip(parts[::2], parts[1::2], strict=True):
        pages = [
            f"{title} <{target.rpartition('.')[0]}>"
            for title, target in TITLED.findall(text)
            if target.endswith((".md", ".rst")) and "://" not in target
        ]
        lines = [f"```{{toctree}}\n:hidden:\n:caption: {heading}\n", *pages, "```\n"]
        trees.append("\n".join(lines))
    return "\n".join([index, *trees])
