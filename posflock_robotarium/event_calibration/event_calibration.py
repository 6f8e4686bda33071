"""From a log of timed lines to a realism profile: speed gain and delay, all else as in another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from posflock_robotarium.event_calibration.times import EventFit, fit_events
from posflock_robotarium.event_calibration.trials import (
    Candidate,
    Heard,
    hear,
    mean_of,
    script_source,
    with_candidate,
)
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.event_lines import events_in
from posflock_robotarium.verify.trials import Limits
from rps_compat.bounded_files import read_bounded
from rps_compat.realism import Profile

#: Dead time to start from where a profile has none, s: that of GRITSBot X robots.
_USUAL_DELAY = 0.195


@dataclass(frozen=True)
class EventCalibration:
    """What a log of timed lines says of how fast and how late robots are.

    Attributes
    ----------
    fit : EventFit
        Gain, delay, and the events that say so.
    base : Profile
        What was assumed of everything else.
    script, log : str
        Names of both files.
    """

    fit: EventFit
    base: Profile
    script: str
    log: str

    @property
    def about(self) -> str:
        """Where the numbers come from, as the profile says it."""
        fit = self.fit
        delay = (
            f"dead time {fit.delay} s"
            if fit.delay is not None
            else f"dead time not determined, {fit.assumed_delay:.3g} s assumed"
        )
        return (
            f"Speed gain {fit.gain}, {delay}: fitted to {len(fit.rows)} timed lines of {self.log}"
            f" by {fit.runs} simulated runs of {self.script}; all else as in {self.base.name}. The"
            " gain is distance per commanded distance of the script's own time: slower wheels, or"
            " steps longer than the script takes them for, would look the same."
        )

    def profile(self, name: str) -> Profile:
        """Return the realism profile in which the events come as they were logged.

        Parameters
        ----------
        name : str
            What reports call the profile.
        """
        delay = self.fit.assumed_delay if self.fit.delay is None else self.fit.delay.value
        fitted = with_candidate(self.base, Candidate(self.fit.gain.value, delay, 0))
        return replace(fitted, name=name, about=self.about)

    def as_dict(self) -> dict[str, Any]:
        """Return everything for JSON."""
        return {"script": self.script, "log": self.log, "base": self.base.name} | asdict(self.fit)


def calibrate_events(
    log: Path,
    script: Path,
    base: Profile,
    trials: int = 16,
    limits: Limits | None = None,
    tell: Callable[[int], None] | None = None,
) -> EventCalibration:
    """Fit speed gain and delay so that a script's timed lines come when they were logged.

    Parameters
    ----------
    log : Path
        What the run on the testbed printed.
    script : Path
        The script that ran.
    base : Profile
        What robots are like apart from gain and delay.
    trials : int
        Runs to simulate around each guess.
    limits : Limits, optional
        What each run may use.
    tell : callable, optional
        Is told how many runs are done, after each.

    Raises
    ------
    LogError
        Where the log cannot be read, has no timed lines, or none that hang on the robots' speed.
    """
    try:
        logged = events_in(read_bounded(log).decode("utf-8", "replace"))
    except OSError as error:
        raise LogError(f"{log}: cannot be read: {error.strerror or error}") from error
    if not logged:
        raise LogError(
            f"{log}: no line with a time in it, such as '[t= 50.3s] at gate'; print the script's"
            " own seconds with each event"
        )
    source = script_source(script)
    done = 0

    def simulate(candidates: list[Candidate]) -> list[Heard]:
        def one_more(_: object) -> None:
            nonlocal done
            done += 1
            if tell is not None:
                tell(done)

        return hear(source, base, candidates, limits or Limits(), one_more)

    delay = _USUAL_DELAY if base.dead_time is None else mean_of(base.dead_time.seconds)
    fit = fit_events(logged, simulate, trials, delay)
    return EventCalibration(fit, base, script.name, log.name)
