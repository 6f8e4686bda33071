"""The picture of the arena: made when asked for, and up to date whenever it is drawn.

The published simulators move every patch and redraw the window in every step. Here a step touches
no picture. One invisible artist stands below all others on the axes; when matplotlib draws them, it
comes first and moves the robots' patches to where the robots are now. So a snapshot, a video frame,
``plt.savefig`` in a script and a live window all show the present, and only they cost anything.

A figure lives as long as its instance, and longer only until the next one is opened: a thousand
instances in one process leave one figure.
"""

import time
import weakref
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rps_compat.lazy import LazyModule

if TYPE_CHECKING:
    from matplotlib.figure import Figure

plt = LazyModule("matplotlib.pyplot")

#: A window is redrawn at most this often, in seconds of real time.
FRAME = 1 / 30

_opened: list[tuple["weakref.ref[Any]", "Figure"]] = []


def _close_orphans() -> None:
    for entry in list(_opened):
        owner, figure = entry
        if owner() is None:
            plt.close(figure)
            _opened.remove(entry)


def _new_figure(size: tuple[float, float]) -> "Figure":
    try:
        figure: Figure = plt.figure(figsize=size)
    except ImportError:  # a window system was asked for where there is none
        plt.switch_backend("Agg")
        figure = plt.figure(figsize=size)
    return figure


def _follower(update: Callable[[], None]) -> Any:
    from matplotlib.artist import Artist

    class Follower(Artist):
        """Moves what follows the robots, just before it is drawn."""

        def draw(self, renderer: Any) -> None:
            update()

    follower = Follower()
    follower.set_zorder(-1e9)
    follower.set_in_layout(False)
    return follower


class ArenaFigure:
    """Figure and axes of one instance.

    Parameters
    ----------
    owner
        The instance; the figure is closed some time after it is gone.
    size
        Width and height in inches.
    limits
        x_min, x_max, y_min, y_max of the axes in metres.
    update
        Brings everything that follows the robots up to date; called before each drawing.

    Attributes
    ----------
    figure : matplotlib.figure.Figure
        pyplot's current figure from now on, so bare ``plt.plot`` draws on the arena.
    axes : rps_compat.axes.Axes
        Axes in metres, equal in both directions, without frame or ticks.
    """

    def __init__(
        self,
        owner: Any,
        size: tuple[float, float],
        limits: tuple[float, float, float, float],
        update: Callable[[], None],
    ) -> None:
        from rps_compat.axes import Axes

        _close_orphans()
        self.figure: Figure = _new_figure(size)
        self.figure.subplots_adjust(left=0, right=1, bottom=0, top=1)
        self.axes = Axes(self.figure, 1, 1, 1)
        self.figure.add_subplot(self.axes)
        self.axes.puts_off = not self.in_window
        _opened.append((weakref.ref(owner), self.figure))
        axes = self.axes
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.set_xlim(limits[0], limits[1])
        axes.set_ylim(limits[2], limits[3])
        axes.set_autoscale_on(False)
        axes.add_artist(_follower(update))
        self._drawn = 0.0

    @property
    def in_window(self) -> bool:
        """Whether somebody can watch: the figure is open, and its canvas is a window's."""
        framework = getattr(self.figure.canvas, "required_interactive_framework", None)
        return framework is not None and bool(plt.fignum_exists(self.figure.number))

    def show(self) -> None:
        """Open the window, if there is one to open, without waiting for it."""
        if self.in_window:
            plt.ion()
            self.figure.show()
            self.redraw()

    def refresh(self) -> None:
        """Redraw the window if its last picture is old enough to be replaced."""
        if time.perf_counter() - self._drawn >= FRAME:
            self.redraw()

    def redraw(self) -> None:
        """Draw the window now, and let it answer to the mouse."""
        self._drawn = time.perf_counter()
        self.figure.canvas.draw_idle()
        self.figure.canvas.flush_events()
