"""How long steps took: recorded, nominal or given, and which of them tell what robots were told.

A loop that is written for 33 ms does not take 33 ms: on hardware the median is that, but a few
steps are late and a few stall.  A log that counts steps instead of reading a clock hides this, and
robots seem to drive that much faster than they were told.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError, ParameterError
from posflock_robotarium.logs.real_time import on_a_grid
from posflock_robotarium.logs.run import GAP_FACTOR, Run
from rps_compat.testbed import WATCHDOG

Floats = NDArray[np.float64]
#: Rows below which nothing sensible can be fitted.
_LEAST_ROWS = 60
#: Mean step of ten hardware runs of 2022 whose loops were written for 33 ms, s: least and largest.
MEASURED_MEANS = (0.0346, 0.0358)
#: Bias of gains in % that is left when stalls are: 1.5 in 400 gains of fifty simulated testbeds.
_REMAINING = 2.0
#: Seconds after which robots have forgotten what they were told before.
MEMORY = 1.0
#: Median steps that some testbed may have, s.
_PLAUSIBLE = (0.005, 0.5)


class TimesOrigin(Enum):
    """Where the times of a log's rows come from."""

    RECORDED = "as recorded"
    NOMINAL = "nominal"
    SIMULATED = "of the simulator"
    GIVEN = "as given"


@dataclass(frozen=True)
class StepTimes:
    """How long each step took.

    Attributes
    ----------
    steps : (K,) array
        Seconds from row to row.
    usable : (K,) boolean array
        Which steps tell what robots were told: no stall in which they may have braked, no missing
        rows, nothing shortly after either.
    origin : TimesOrigin
        Where the times come from.
    unclear : tuple of float
        Seconds of the run at which steps are left out.
    hidden : tuple of (float, float)
        Stalls that nominal times hide: when, s of the log, and by how much longer they took, s.
    """

    steps: Floats
    usable: NDArray[np.bool_]
    origin: TimesOrigin
    unclear: tuple[float, ...] = ()
    hidden: tuple[tuple[float, float], ...] = ()

    @property
    def t(self) -> Floats:
        """Return the (K + 1,) times of the rows, s."""
        return np.concatenate([[0.0], np.cumsum(self.steps)])

    @property
    def median(self) -> float:
        """Median step, s."""
        return float(np.median(self.steps))

    def __str__(self) -> str:
        shortest, longest = 1e3 * self.steps.min(), 1e3 * self.steps.max()
        if longest - shortest < 0.1:
            return f"steps of {1e3 * self.median:.4g} ms, {self.origin.value}"
        return (
            f"steps of {1e3 * self.median:.1f} ms (mean {1e3 * self.steps.mean():.1f}, longest"
            f" {longest:.0f} ms), {self.origin.value}"
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """What must be known of the times before the fit is believed."""
        said = []
        if self.origin is TimesOrigin.NOMINAL:
            low, high = (100 * (mean / self.median - 1) for mean in MEASURED_MEANS)
            said.append(
                f"every step of the log takes {1e3 * self.median:.4g} ms: a nominal time, not a"
                " measured one. Loops of hardware that were written for 33 ms took"
                f" {1e3 * MEASURED_MEANS[0]:.1f} to {1e3 * MEASURED_MEANS[1]:.1f} ms on average;"
                f" where this one did, too, robots seem {low:.0f} to {high:.0f} % faster than they"
                " were. Give posflock calibrate what you know, with --dt (the mean) or --step-times"
            )
        if self.hidden:
            lost = sum(length for _, length in self.hidden)
            mean = self.steps.mean() + lost / len(self.steps)
            said.append(
                f"the motion shows stalls that the times hide ({len(self.hidden)}, at"
                f" {_list(at for at, _ in self.hidden)} s, {lost:.1f} s in all): the steps took"
                f" {1e3 * mean:.1f} ms on average, not {1e3 * self.median:.4g}. They are left out;"
                " what remains of the bias, from the small delays in between, is within"
                f" {_REMAINING:.0f} % for such loops"
            )
        if self.unclear:
            said.append(
                f"stalls or gaps ({len(self.unclear)}, at {_list(self.unclear)} s) are left out"
                " with the second after each: the log does not say what robots were told in them"
            )
        return tuple(said)

    def without(self, stalls: Mapping[int, float]) -> StepTimes:
        """Return the same without rows that took longer than they say, and what follows them.

        Parameters
        ----------
        stalls : mapping
            From rows to how many times as long as they say they took.
        """
        t, usable, hidden = self.t, self.usable.copy(), []
        for row in sorted(stalls):
            if usable[row]:  # what follows a stall is wrong because of it
                hidden.append((float(t[row]), float((stalls[row] - 1) * self.steps[row])))
            usable[_shadow(t, row)] = False
        return replace(self, usable=usable, hidden=tuple(hidden))


def _shadow(t: Floats, row: int) -> slice:
    """Return a step and those after it in which robots still follow what they were told in it."""
    return slice(row, int(np.searchsorted(t, t[row + 1] + MEMORY)))


def _list(times: Iterable[float]) -> str:
    """Name the first few of some times."""
    named = [f"{at:.1f}" for at in times]
    return ", ".join(named[:5]) + (", …" if len(named) > 5 else "")


def step_times_of(log: Run, given: float | Floats | None = None) -> StepTimes:
    """Return how long a log's steps took.

    Parameters
    ----------
    log : Run
        Poses over time.
    given : float or (K,) array, optional
        What the user knows better, s: the mean step, or each; None for the log's own times.

    Raises
    ------
    LogError
        Where the log is too short, or its times cannot be those of robots.
    """
    rows = len(log.t)
    if rows < _LEAST_ROWS:
        raise LogError(f"the log has {rows} rows; a calibration needs {_LEAST_ROWS}")
    if given is not None:
        steps, origin = np.diff(retimed(log, given).t), TimesOrigin.GIVEN
    else:
        steps = np.diff(log.t if log.real_time is None else log.real_time)
        origin = _origin(log, steps)
    median = float(np.median(steps))
    if not _PLAUSIBLE[0] <= median <= _PLAUSIBLE[1]:
        raise LogError(
            f"the log's rows are {median:.3g} s apart, which no testbed's are; give the time"
            " between rows with --dt"
        )
    stalls = steps > WATCHDOG
    if on_a_grid(steps):  # rows of an even clock are not late, they are missing
        stalls |= steps > GAP_FACTOR * median
    t = np.concatenate([[0.0], np.cumsum(steps)])
    usable = np.ones(rows - 1, dtype=bool)
    for row in np.flatnonzero(stalls):
        usable[_shadow(t, int(row))] = False
    return StepTimes(steps, usable, origin, tuple(t[:-1][stalls].tolist()))


def retimed(log: Run, steps: float | Floats) -> Run:
    """Return the same run with other times between its rows.

    Parameters
    ----------
    log : Run
        Whose times are not to be believed.
    steps : float or (K,) array
        Seconds from row to row, one for all or each.

    Raises
    ------
    ParameterError
        Where there is not one for each, or one is not above 0.
    """
    checked = _checked(np.asarray(steps, dtype=float), len(log.t) - 1)
    return replace(log, t=np.concatenate([[0.0], np.cumsum(checked)]))


def _checked(given: Floats, steps: int) -> Floats:
    if given.ndim == 0:
        given = np.full(steps, float(given))
    if given.shape != (steps,):
        raise ParameterError(
            f"{given.size} step times for a log of {steps + 1} rows; give {steps}, one from each"
            " row to the next"
        )
    if not (np.isfinite(given).all() and (given > 0).all()):
        raise ParameterError(f"step times from {given.min()} s; expected seconds above 0")
    return given


def _origin(log: Run, steps: Floats) -> TimesOrigin:
    if log.simulated:
        return TimesOrigin.SIMULATED
    return TimesOrigin.NOMINAL if on_a_grid(steps) else TimesOrigin.RECORDED


def read_step_times(path: Path, rows: int) -> Floats:
    """Read step times from a text file or a .npy file.

    Parameters
    ----------
    path : Path
        Numbers: seconds from row to row, or the time of each row.
    rows : int
        How many rows the log has.

    Returns
    -------
    (K,) array
        Seconds from row to row.

    Raises
    ------
    LogError
        Where the file cannot be read, or holds another number of times.
    """
    try:
        if path.suffix == ".npy":
            values = np.load(path, allow_pickle=False)
        else:
            values = np.loadtxt(path, delimiter="," if path.suffix == ".csv" else None)
        steps: Floats = np.asarray(values, dtype=float).ravel()
    except (OSError, ValueError) as error:
        raise LogError(f"{path}: cannot be read as step times ({error})") from error
    if len(steps) == rows and (np.diff(steps) > 0).all():
        steps = np.diff(steps)
    if len(steps) == rows:  # one a row: the last leads out of the log
        steps = steps[:-1]
    if len(steps) != rows - 1:
        raise LogError(
            f"{path}: {len(steps)} numbers for a log of {rows} rows; expected {rows - 1} steps or"
            f" {rows} times in seconds"
        )
    return steps
