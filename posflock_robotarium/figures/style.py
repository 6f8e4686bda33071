"""How every figure of the project looks: its palette, its type, its files.

Figures are drawn without a display and without touching matplotlib's global state, as PNG
for the screen and PDF for the paper.  Curves differ in colour (Okabe and Ito's palette,
safe for colour-blind readers) *and* in dash, so that they survive a black-and-white
printer.
"""

from __future__ import annotations

import functools
import io
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from posflock_robotarium.figures.palette import BLACK, BLUE, GREEN, GREY, ORANGE
from rps_compat.whole_files import write_whole, written_together

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["BLACK", "BLUE", "GREEN", "GREY", "ORANGE", "in_style", "new_figure", "save"]

_STYLE: dict[str, Any] = {
    "font.size": 8,
    "axes.labelsize": 8,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "pdf.fonttype": 42,
}

_Arguments = ParamSpec("_Arguments")
_Result = TypeVar("_Result")


def in_style(draw: Callable[_Arguments, _Result]) -> Callable[_Arguments, _Result]:
    """Let a function draw in our style without changing the caller's.

    Parameters
    ----------
    draw : callable
        What draws.
    """

    @functools.wraps(draw)
    def styled(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Result:
        import matplotlib.style

        with matplotlib.style.context(_STYLE):
            return draw(*args, **kwargs)

    return styled


@in_style
def save(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write a figure as NAME.png and NAME.pdf and return both paths.

    Parameters
    ----------
    figure : Figure
        The figure; it is laid out for good.
    folder : Path
        Where the files are put; made if it is not there.
    name : str
        NAME of the files.

    Raises
    ------
    OutputError
        Where the files cannot be written.
    """
    paths = [folder / f"{name}.png", folder / f"{name}.pdf"]
    # Drawn in memory: where a disk is full, matplotlib says something else. No dates inside: the
    # same run gives the same bytes.
    png, pdf = io.BytesIO(), io.BytesIO()
    figure.savefig(png, format="png", dpi=200, metadata={"Software": None})
    figure.set_layout_engine("none")  # laid out once, and the same in both
    figure.savefig(pdf, format="pdf", metadata={"CreationDate": None, "Producer": None})
    with written_together(folder) as draft:
        for path, drawn in zip(paths, (png, pdf), strict=True):
            write_whole(draft / path.name, drawn.getvalue())
    return paths


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure, its labels sized for print.

    Parameters
    ----------
    width, height : float
        Its size, inches.
    """
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")
