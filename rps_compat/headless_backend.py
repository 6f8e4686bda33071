"""A matplotlib backend without a screen: Agg that draws when a picture is taken, not before.

Scripts call ``canvas.draw()``, ``plt.pause()`` or ``plt.draw()`` in every step, to be seen. Nobody
looks, so these cost nothing here; ``savefig`` and the pixel buffer draw what they deliver, as ever.
Select it with ``MPLBACKEND=module://rps_compat.headless_backend``.

A window also has an event loop, and a script may live by it: ``FuncAnimation`` moves the robots in
the callback of a timer. ``plt.show()`` runs such timers, in the time of the clock in force, until
none is left. What would go on until somebody closes the window goes on for as long as the testbed
lets a run last; an animation that would repeat plays once. Keys and the mouse are never touched.
"""

import math
import time
import weakref
from collections.abc import Callable
from itertools import count
from typing import Any

from matplotlib._pylab_helpers import Gcf
from matplotlib.backend_bases import FigureManagerBase, TimerBase
from matplotlib.backends.backend_agg import FigureCanvasAgg

from rps_compat.clock.time_functions import clock_in_force
from rps_compat.testbed import MAX_DURATION

#: Seconds without a step after which a window is closed that other threads keep open.
CLOSED_AFTER = 30.0
#: What the run has to tell about its windows; the keys are words for people.
notes: dict[str, None] = {}

_order = count()
_running: "weakref.WeakSet[HeadlessTimer]" = weakref.WeakSet()


class HeadlessTimer(TimerBase):
    """A timer of the event loop; it is due at times of the clock in force.

    Parameters
    ----------
    canvas : HeadlessCanvas
        The window whose event loop it belongs to.
    *arguments, **named
        As for `matplotlib.backend_bases.TimerBase`.
    """

    def __init__(self, canvas: "HeadlessCanvas", *arguments: Any, **named: Any) -> None:
        self.canvas = weakref.ref(canvas)
        self.due, self._from, self._serves = math.inf, 0.0, False
        self.number, self._repeats = next(_order), False
        super().__init__(*arguments, **named)

    def _timer_start(self) -> None:
        self._from = time.monotonic()
        self.due = self._from + self.interval / 1000
        _running.add(self)

    def _timer_stop(self) -> None:
        self.due = math.inf
        _running.discard(self)

    def _timer_set_interval(self) -> None:
        if self.due < math.inf and not self._serves:
            self._timer_start()

    @property
    def in_window(self) -> bool:
        """Whether the window that it belongs to is open."""
        canvas = self.canvas()
        return any(manager.canvas is canvas for manager in Gcf.figs.values())

    def tick(self) -> None:
        """Call what is to be called, and be due again: at once if that took too long."""
        repeating = self._played_once()
        self._serves = True
        try:
            self._on_timer()  # type: ignore[attr-defined]  # of every timer
        finally:
            self._serves = False
        if any(animation.event_source is None for animation in repeating):
            notes["an animation that would repeat for ever was played once"] = None
        if self.single_shot:
            self.stop()
        if self.due < math.inf:
            self._from = max(self._from + self.interval / 1000, time.monotonic() - 1e-9)
            self.due = self._from

    def _played_once(self) -> list[Any]:
        """Let the animations of this timer not repeat; return those that would have."""
        owners: list[Any] = [getattr(function, "__self__", None) for function, *_ in self.callbacks]
        animations = [owner for owner in owners if getattr(owner, "_repeat", None) is not None]
        for animation in animations:
            self._repeats |= animation._repeat
            animation._repeat = False
        return animations if self._repeats else []


def _serve(until: float, go_on: Callable[[], bool]) -> None:
    """Call each timer when it is due, until a time of the clock in force, while `go_on` says so."""
    while go_on():
        timer = min(_running, key=lambda timer: (timer.due, timer.number), default=None)
        moment = until if timer is None else min(timer.due, until)
        left = moment - time.monotonic()
        if left > 0:
            time.sleep(left)
        elif timer is None or timer.due > moment:
            return
        else:
            timer.tick()


class HeadlessManager(FigureManagerBase):
    """A figure manager whose window never opens, and is never closed by anybody."""

    def show(self) -> None:
        """Stand in for ``figure.show``: tell those who wait for the first picture."""
        canvas = self.canvas
        if isinstance(canvas, HeadlessCanvas) and canvas.callbacks.callbacks.get("draw_event"):
            canvas.draw_now()

    @classmethod
    def start_main_loop(cls) -> None:
        """Run the timers of the open windows, and let other threads drive, as long as they do."""
        clock = clock_in_force()
        if not _running and (clock is None or clock.solo):
            return
        end = time.monotonic() + MAX_DURATION
        time.sleep(0)  # threads that have just been started have their turn

        def is_open() -> bool:
            if any(timer.in_window for timer in _running):
                return True
            return clock is not None and clock.others_step_within(CLOSED_AFTER)

        while is_open():
            _serve(min(time.monotonic() + 1.0, end), is_open)
            if time.monotonic() >= end:
                notes[
                    f"plt.show() ended after {MAX_DURATION:g} s, since nobody closes the window"
                ] = None
                return


class HeadlessCanvas(FigureCanvasAgg):
    """A canvas that remembers that it should be drawn, and is when its pixels are asked for."""

    manager_class = HeadlessManager
    _owed = False
    _looping = False

    def draw(self) -> None:
        """Remember to draw."""
        self._owed = True

    def draw_idle(self, *args: Any, **kwargs: Any) -> None:
        """Remember to draw.

        Parameters
        ----------
        *args, **kwargs
            Matplotlib's; nothing depends on them.
        """
        self._owed = True

    def draw_now(self) -> None:
        """Draw."""
        self._owed = False
        super().draw()  # type: ignore[no-untyped-call]

    def flush_events(self) -> None:
        """Run the timers that are due."""
        if _running:
            _serve(time.monotonic(), lambda: True)

    def start_event_loop(self, timeout: float = 0) -> None:
        """Run the timers on the clock in force, which is how a pause waits.

        Without a limit, until there are none or ``stop_event_loop`` is called: nothing else comes.

        Parameters
        ----------
        timeout : float
            How long, s; zero for no limit.
        """
        self._looping = True
        if not _running:
            time.sleep(max(timeout, 0))
        elif timeout > 0:
            _serve(time.monotonic() + timeout, lambda: self._looping)
        else:
            end = time.monotonic() + MAX_DURATION
            _serve(end, lambda: self._looping and bool(_running))

    def stop_event_loop(self) -> None:
        """End the innermost event loop."""
        self._looping = False

    def new_timer(self, *arguments: Any, **named: Any) -> HeadlessTimer:
        """Make a timer of this window.

        Parameters
        ----------
        *arguments, **named
            As for `HeadlessTimer`.
        """
        return HeadlessTimer(self, *arguments, **named)

    def buffer_rgba(self) -> memoryview:
        """Return the pixels, drawn first if they are due."""
        if self._owed:
            self.draw_now()
        return memoryview(super().buffer_rgba())  # type: ignore[no-untyped-call]


FigureCanvas = HeadlessCanvas
FigureManager = HeadlessManager
