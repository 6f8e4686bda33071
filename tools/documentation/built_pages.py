"""What holds of the built site: no dead link, nothing from elsewhere, no public name left out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

from tools.documentation.api_pages import FOLDER
from tools.documentation.public_names import PublicSurface

#: Attributes by which a page loads something, by element.
LOADED = {("script", "src"), ("link", "href"), ("img", "src"), ("iframe", "src")}


@dataclass
class BuiltPage(HTMLParser):
    """Anchors and links of one page.

    Attributes
    ----------
    anchors : set of str
        What a link to this page can name after ``#``.
    links : list of str
        Targets of links.
    loaded : list of str
        What the page needs to be shown.
    """

    anchors: set[str] = field(default_factory=set)
    links: list[str] = field(default_factory=list)
    loaded: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note what an element says.

        Parameters
        ----------
        tag : str
            Its name.
        attrs : list of tuple
            Its attributes, with their values.
        """
        for name, value in attrs:
            if value is None:
                continue
            if name == "id":
                self.anchors.add(value)
            elif (tag, name) in LOADED:
                self.loaded.append(value)
            elif (tag, name) == ("a", "href"):
                self.links.append(value)


def faults_of(site: Path, surface: PublicSurface) -> list[str]:
    """Return what is wrong with a built site, a line each.

    Parameters
    ----------
    site : Path
        The folder with its ``index.html``.
    surface : PublicSurface
        What has to have an entry.
    """
    pages = {path: _read(path) for path in sorted(site.rglob("*.html"))}
    found = [fault for path in pages for fault in _dead(path, pages, site)]
    for entry, name in surface.documented.items():
        page = pages.get(site / FOLDER / f"{name.module}.html")
        if page is None or entry not in page.anchors:
            found.append(f"{entry} is public and has no entry in the API reference")
    return found


def _read(path: Path) -> BuiltPage:
    page = BuiltPage()
    page.feed(path.read_text(encoding="utf-8"))
    return page


def _dead(path: Path, pages: dict[Path, BuiltPage], site: Path) -> Iterator[str]:
    """Yield what of a page leads nowhere, or is loaded from elsewhere."""
    where = path.relative_to(site)
    for link in dict.fromkeys([*pages[path].loaded, *pages[path].links]):
        parts = urlsplit(link)
        if parts.scheme or parts.netloc:
            if link in pages[path].loaded and parts.scheme != "data":
                yield f"{where}: loads {link}, and the site has to work without a network"
            continue
        target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
        if not target.is_file():
            yield f"{where}: {link} leads nowhere"
        elif (
            parts.fragment
            and target in pages
            and unquote(parts.fragment) not in pages[target].anchors
        ):
            yield f"{where}: {link} names an anchor that is not there"
