"""A matplotlib backend without a screen: Agg that draws when a picture is taken, not before.

Scripts call ``canvas.draw()``, ``plt.pause()`` or ``plt.draw()`` in every step, to be seen. Nobody
looks, so these cost nothing here; ``savefig`` and the pixel buffer draw what they deliver, as ever.
Select it with ``MPLBACKEND=module://rps_compat.headless_backend``.
"""

import time
from typing import Any

from matplotlib.backend_bases import FigureManagerBase
from matplotlib.backends.backend_agg import FigureCanvasAgg


class HeadlessManager(FigureManagerBase):
    """A figure manager whose window never opens."""

    @classmethod
    def pyplot_show(cls, *, block: bool | None = None) -> None:
        """Stand in for ``plt.show``: there is nobody to show it to."""

    def show(self) -> None:
        """Stand in for ``figure.show``."""


class HeadlessCanvas(FigureCanvasAgg):
    """A canvas that remembers that it should be drawn, and is when its pixels are asked for."""

    manager_class = HeadlessManager
    _owed = False

    def draw(self) -> None:
        """Remember to draw."""
        self._owed = True

    def draw_idle(self, *args: Any, **kwargs: Any) -> None:
        """Remember to draw."""
        self._owed = True

    def flush_events(self) -> None:
        """Answer no events: there are none."""

    def start_event_loop(self, timeout: float = 0) -> None:
        """Let `timeout` seconds pass on the clock in force, which is how ``plt.pause`` waits."""
        time.sleep(max(timeout, 0))

    def buffer_rgba(self) -> memoryview:
        """Return the pixels, drawn first if they are due."""
        if self._owed:
            self._owed = False
            super().draw()  # type: ignore[no-untyped-call]
        return memoryview(super().buffer_rgba())  # type: ignore[no-untyped-call]


FigureCanvas = HeadlessCanvas
FigureManager = HeadlessManager
