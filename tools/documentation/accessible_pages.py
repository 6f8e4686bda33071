"""What the theme leaves undone for those who use a keyboard or a screen reader, done on each page.

axe-core judges the result: `tests/test_built_site.py`.
"""

from __future__ import annotations

import re
from pathlib import Path

#: What stands in the pages, and what has to stand there.
MENDED = (
    # Captions of the navigation are headings, of some level.
    ('<p class="caption" role="heading">', '<p class="caption" role="heading" aria-level="2">'),
    # Two regions of one sort are told apart by their names.
    ('<aside class="sidebar-drawer">', '<aside class="sidebar-drawer" aria-label="All pages">'),
    ('<aside class="toc-drawer', '<aside aria-label="On this page" class="toc-drawer'),
    # What scrolls can be reached by keyboard.
    ("<pre>", '<pre tabindex="0">'),
    ('<div class="table-wrapper', '<div tabindex="0" class="table-wrapper'),
    # A column without a name has no header.
    ('<th class="head"><p></p></th>', "<td></td>"),
)
#: The parameters of a signature, which are told as the descriptions of no terms.
PARAMETERS = re.compile(r'(?<=<span class="sig-paren">\(</span>\n\n)<dl>(.*?)</dl>', re.S)


def make_accessible(site: Path) -> None:
    """Mend every page of a built site.

    Parameters
    ----------
    site : Path
        The folder with its ``index.html``.
    """
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        for found, mended in MENDED:
            text = text.replace(found, mended)
        text = PARAMETERS.sub(_as_lines, text)
        if page.name == "search.html":
            text = text.replace(
                '<div id="search-results">', '<h1>Search</h1>\n<div id="search-results">'
            )
        page.write_text(text, encoding="utf-8")


def _as_lines(signature: re.Match[str]) -> str:
    lines = signature[1].replace("<dd>", '<span class="sig-line">').replace("</dd>", "</span>")
    return f"<span>{lines}</span>"
