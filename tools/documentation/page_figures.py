"""Pictures that the examples of a page draw, put beside the code that draws them.

A Python block that ends with ``savefig("name.svg")`` makes its picture when the site is built; the
blocks of such a page run in order, as the tests run them. On a code host the reader sees the code.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path

from posflock_robotarium.figures.style import in_style

BLOCK = re.compile(r"^```python\n(.*?)^```\n", re.M | re.S)
SAVED = re.compile(r"^\w+\.savefig\(\"([\w-]+\.svg)\"\)  # (.+)$", re.M)


def with_figures(text: str, place: Path) -> str:
    """Return a page with the pictures that it draws, which are put beside it.

    Parameters
    ----------
    text : str
        The page, in Markdown.
    place : Path
        Where it is going to stand.

    Raises
    ------
    ValueError
        A block that draws says nothing of its picture for those who do not see it.
    """
    if "savefig(" not in text:
        return text
    namespace: dict[str, object] = {"__name__": "__page__"}
    with tempfile.TemporaryDirectory() as folder, _within(folder):

        def run(block: re.Match[str]) -> str:
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(block[1], f"{place.name}, an example", "exec"), namespace)
            if "savefig(" not in block[1]:
                return block[0]
            saved = SAVED.search(block[1])
            if saved is None:
                raise ValueError(
                    f'{place.name}: expected, on one line, figure.savefig("name.svg")'
                    f"  # what the picture shows; got\n{block[1]}"
                )
            os.replace(saved[1], place.parent / saved[1])
            return f"{block[0]}\n![{saved[2]}]({saved[1]})\n"

        return in_style(BLOCK.sub)(run, text)


@contextlib.contextmanager
def _within(folder: str) -> Iterator[None]:
    """Go into a folder and back: what `contextlib.chdir` is from Python 3.11 on."""
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)
