"""What is said of poses that are not believed: which robot, when, and what became of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.logs.plausibility import Sightings, Unbelieved, Why, fastest
from posflock_robotarium.logs.run import GAP_FACTOR, Run

#: How many robots and times a sentence names.
_NAMED = 6
#: Seconds without a row from which on robots were not seen: the testbed's watchdog stops them then.
_STALL = 0.5
#: Seconds of one pose to the end of a log from which on that is worth a word.
_LASTING = 1.0


@dataclass(frozen=True)
class Losses:
    """What a log lost of its robots.

    Attributes
    ----------
    seen : float
        Mean share of the robots that are seen, over the rows in which the camera told anything.
    never : tuple of int
        Robots that are never seen.
    longest : float
        Longest time that a robot which is seen at some time was not, s; 0 where all always were.
        Gaps of the whole log count, too.
    longest_robot : int
        Whose that was; -1 for nobody's.
    """

    seen: float
    never: tuple[int, ...]
    longest: float
    longest_robot: int


def losses_of(run: Run, found: Sightings) -> Losses:
    """Count what a log lost.

    Parameters
    ----------
    run : Run
        Poses as tracked.
    found : Sightings
        What of them is believed.
    """
    placed = np.take_along_axis(found.placed, found.names, axis=1)
    told = ~found.repeated
    share = float(placed[told].mean()) if told.any() else 0.0
    never = tuple(int(n) for n in np.flatnonzero(~placed.any(axis=0)))
    longest, whose = 0.0, -1
    for n in np.flatnonzero(placed.any(axis=0)):
        unseen = _longest(run.t, np.flatnonzero(placed[:, n]), run.step)
        if unseen > longest:
            longest, whose = unseen, int(n)
    return Losses(share, never, longest, whose)


def _longest(t: NDArray[np.float64], rows: NDArray[np.intp], step: float) -> float:
    """Return the longest time, s, between rows of one robot beyond the usual one."""
    index = np.concatenate([[-1], rows, [len(t)]])
    times = np.concatenate([t[:1] - step, t[rows], t[-1:] + step])
    unseen = (np.diff(index) > 1) | (np.diff(times) > max(_STALL, GAP_FACTOR * step))
    return float(np.where(unseen, np.diff(times) - step, 0.0).max())


def too_fast(run: Run, found: Sightings) -> str:
    """Say that no such robot moves like this.

    Parameters
    ----------
    run : Run
        Poses as tracked.
    found : Sightings
        What of them is believed: nothing.
    """
    share = float(found.jumps.mean())
    return f"{share:.0%} of all motion is {_limits(run)}: other robots, times or units?"


def what_is_lost(run: Run, found: Sightings) -> str:
    """Say which poses are left out, and which jumps tell so; "" where all are believed.

    Parameters
    ----------
    run : Run
        Poses as tracked.
    found : Sightings
        What of them is believed.
    """
    sentences: list[str] = []
    rows, robots = np.nonzero(found.jumps)
    if rows.size:
        jumps = [f"robot {n} at {run.t[k + 1]:.1f} s" for k, n in zip(rows, robots, strict=True)]
        count = f"{len(jumps)} jump{'s' if len(jumps) > 1 else ''}"
        sentences.append(f"{count} {_limits(run)}: {_some(jumps)}.")
    for exchange in found.exchanges:
        sentences.append(f"{str(exchange).capitalize()}.")
    if found.exchanges:
        sentences.append(
            "The team's places are right all the same; --fix-swaps gives each robot its own back."
        )
    named = [str(entry) for entry in found.unbelieved if entry.why is not Why.EXCHANGED]
    if named:
        sentences.append(f"Left out: {_some(_together(found.unbelieved, named))}.")
    return " ".join(sentences)


def who_is_seen(run: Run, losses: Losses) -> str:
    """Say how many robots are seen, and who is not for longest; "" where all always are.

    Parameters
    ----------
    run : Run
        Poses as tracked.
    losses : Losses
        What it lost.
    """
    if losses.seen >= 1.0:
        return ""
    # Cut, not rounded: 3.998 of 4 are not 4.
    mean = math.floor(100 * losses.seen * run.robots) / 100
    words = f"On average {mean:g} of {run.robots} robots are seen"
    if losses.never:
        some = ", ".join(map(str, losses.never))
        words += f", robot{'s' if len(losses.never) > 1 else ''} {some} never"
    if losses.longest > 0:
        words += f"; robot {losses.longest_robot} is not for {losses.longest:.1f} s in a row"
    return f"{words}."


def perhaps_frozen(run: Run) -> str:
    """Say who has exactly one pose to the end of a log, after driving; "" for nobody.

    A simulated robot may stop like that, a tracked one never does.

    Parameters
    ----------
    run : Run
        Poses as tracked.
    """
    if run.simulated:
        return ""
    named = []
    for n in range(run.robots):
        steps = np.hypot(*np.diff(run.poses[:, :2, n], axis=0).T)
        new = np.flatnonzero(~((steps == 0) & (np.diff(run.poses[:, 2, n]) == 0)))
        last = int(new[-1]) + 1 if new.size else 0
        before = steps[max(0, last - 16) : last]
        before = before[np.isfinite(before)]
        abrupt = len(before) > 5 and before[-1] > max(1e-4, 0.5 * float(np.median(before)))
        if abrupt and run.t[-1] - run.t[last] >= _LASTING:
            named.append(f"robot {n} from {run.t[last]:.1f} s on")
    if not named:
        return ""
    return f"Exactly one pose to the end: {_some(named)}; stopped at once, or not tracked any more."


def _limits(run: Run) -> str:
    speed, rate = fastest(run.robot)
    return f"faster than wheels turn ({speed:.2g} m/s, {rate:.2g} rad/s)"


def _together(entries: tuple[Unbelieved, ...], named: list[str]) -> list[str]:
    """Count short losses that are too many to name."""
    if len(named) <= _NAMED:
        return named
    counted = []
    for why in Why:
        of_why = [entry for entry in entries if entry.why is why]
        if why is Why.EXCHANGED or not of_why:
            continue
        rows = sum(entry.rows for entry in of_why)
        robots = sorted({entry.robot for entry in of_why})
        longest = max(of_why, key=lambda entry: entry.end - entry.start)
        some = ", ".join(map(str, robots[:20])) + (" …" if len(robots) > 20 else "")
        counted.append(
            f"{rows} poses {why.value} (robot{'s' if len(robots) > 1 else ''} {some}; longest: "
            f"robot {longest.robot}, {longest.start:.1f} to {longest.end:.1f} s)"
        )
    return counted


def _some(words: list[str]) -> str:
    """Return the first of many, and how many more there are."""
    more = f" and {len(words) - _NAMED} more" if len(words) > _NAMED else ""
    return "; ".join(words[:_NAMED]) + more
