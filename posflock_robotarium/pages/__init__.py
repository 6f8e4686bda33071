"""Scripts and styles of pages, and what all pages share of them: colours, numbers, the arena.

The report's page and the live page draw the same arena in the same look.
"""

from __future__ import annotations

from importlib import resources

#: What every page begins with: colours and how numbers are written; the arena from above.
SHARED_SCRIPTS = ("look.js", "arena.js")
SHARED_STYLE = "look.css"


def asset(name: str, package: str = "posflock_robotarium.pages") -> str:
    """Return the text of a file that comes with the package.

    Parameters
    ----------
    name : str
        The file, in the package's folder ``assets``.
    package : str
        Whose it is.
    """
    return (resources.files(package) / "assets" / name).read_text("utf-8")
