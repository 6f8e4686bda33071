"""Links of the pages: they lead to files of the repository, and on the site to pages.

On a code host a link to ``../../posflock_robotarium/flocking/law.py`` shows the file. Here such a
file gets a page, too, and a folder a page that lists its files.
"""

from __future__ import annotations

import posixpath
import re
from dataclasses import dataclass, field
from pathlib import Path

#: A link's target, or a picture's, on one line.
LINK = re.compile(r"(?<=\]\()([^)\s]+)(?=\))")
#: A fenced block, in which nothing is a link.
FENCED = re.compile(r"^(`{3,}).*?^\1$", re.M | re.S)
LANGUAGES = {".py": "python", ".toml": "toml"}
#: Pages beside `docs/`, and where they stand on the site.
BESIDE = {
    "SECURITY.md": "project/SECURITY.md",
    "CONTRIBUTING.md": "project/CONTRIBUTING.md",
    "CHANGELOG.md": "project/CHANGELOG.md",
}


@dataclass
class RepositoryLinks:
    """Rewrites links, and remembers which files need a page for them.

    Attributes
    ----------
    root : Path
        Of the repository.
    shown : dict of str
        Path of a file or folder that is linked to → path of its page on the site.
    """

    root: Path
    shown: dict[str, str] = field(default_factory=dict)

    def place_of(self, path: str) -> str:
        """Return where a file of the repository stands on the site.

        Parameters
        ----------
        path : str
            From the root of the repository.

        Raises
        ------
        FileNotFoundError
            There is no such file.
        """
        if path in BESIDE:
            return BESIDE[path]
        if path == "README.md":
            return "index.md"
        if path.startswith("docs/"):
            return path.removeprefix("docs/")
        if not (self.root / path).exists():
            raise FileNotFoundError(f"a page links to {path}, which is not there")
        return self.shown.setdefault(path, f"source/{path}.md")

    def rewritten(self, text: str, path: str) -> str:
        """Return a page with its links as they have to be on the site.

        Parameters
        ----------
        text : str
            The page.
        path : str
            Its own path, from the root of the repository.
        """

        def rewrite(link: re.Match[str]) -> str:
            target, mark, anchor = link[0].partition("#")
            if not target or "://" in target or target.startswith("mailto:"):
                return link[0]
            there = posixpath.normpath(posixpath.join(posixpath.dirname(path), target))
            here = posixpath.dirname(self.place_of(path))
            return posixpath.relpath(self.place_of(there), here or ".") + mark + anchor

        parts, end = [], 0
        for block in FENCED.finditer(text):
            parts += [LINK.sub(rewrite, text[end : block.start()]), block[0]]
            end = block.end()
        return "".join([*parts, LINK.sub(rewrite, text[end:])])

    def source_pages(self) -> dict[str, str]:
        """Return a page for every file and folder that is linked to, by its place on the site."""
        pages: dict[str, str] = {}
        while waiting := self.shown.keys() - pages.keys():
            for path in sorted(waiting):
                pages[path] = self._page(path)
        return {self.shown[path]: page for path, page in pages.items()}

    def _page(self, path: str) -> str:
        head = f"---\norphan: true\nnosearch: true\n---\n# {Path(path).name}\n\n`{path}`\n\n"
        file = self.root / path
        if not file.is_dir():
            language = LANGUAGES.get(file.suffix, "text")
            return f"{head}``````{language}\n{file.read_text(encoding='utf-8')}``````\n"
        inside = sorted(
            entry.name + "/" * entry.is_dir()
            for entry in file.iterdir()
            if not entry.name.startswith((".", "__pycache__"))
        )
        place = posixpath.dirname(self.shown[path])
        return head + "".join(
            f"- [{name}]({posixpath.relpath(self.place_of(f'{path}/{name}'.rstrip('/')), place)})\n"
            for name in inside
        )
