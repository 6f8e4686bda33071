"""Real time for those who watch: a step that waits for its slot, a window that keeps up."""

from time import perf_counter, sleep
from typing import TYPE_CHECKING

from rps_compat.session import Session, StepListener

if TYPE_CHECKING:
    from rps_compat.figure import ArenaFigure


class Pace(StepListener):
    """Called after each step of an instance that is watched or that has to wait.

    Parameters
    ----------
    figure
        The instance's figure, if it is in a window.
    wait
        Whether each step waits until its time step is over.
    """

    def __init__(self, figure: "ArenaFigure | None", wait: bool) -> None:
        self._figure, self._wait = figure, wait
        self._slot = perf_counter()

    def after_step(self, time_step: float, /) -> None:
        """Wait for the end of the step's slot; redraw the window when it is due."""
        figure = self._figure
        if figure is not None and figure.in_window:
            figure.refresh()
        if self._wait:
            now = perf_counter()
            # A late loop starts its next slot now, as on the testbed: nothing is caught up.
            self._slot = max(self._slot + time_step, now)
            sleep(self._slot - now)


def pace_of(figure: "ArenaFigure | None", real_time: bool, session: Session) -> StepListener | None:
    """Pace of an instance; None where nobody watches and nothing waits.

    Parameters
    ----------
    figure
        The instance's figure, if it has one.
    real_time
        Whether the instance asked for ``sim_in_real_time``.
    session
        Has the last word: a pace of its own, or whether to wait. True waits, False never does, None
        waits only for a window.
    """
    if session.pace is not None:
        return session.pace
    wait = session.wait
    watched = figure is not None and figure.in_window
    waits = real_time and (watched if wait is None else wait)
    return Pace(figure if watched else None, waits) if watched or waits else None
