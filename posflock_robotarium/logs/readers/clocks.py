"""Robots that were each logged on a clock of their own, brought to a common one.

The common clock ticks as the slowest of them, while all are seen. Between two samples of a robot
its pose lies on the line between them (its heading on the shorter arc), unless they are so far
apart that it was not seen in between: then it is unknown.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.found import Found
from posflock_robotarium.logs.run import GAP_FACTOR

Floats = NDArray[np.float64]

MOST_SAMPLES = 10_000_000
"""Ticks of a common clock beyond which the clocks cannot belong together."""


@dataclass(frozen=True)
class Track:
    """One robot on its own clock.

    Attributes
    ----------
    name : str
        What it is called.
    t : (T,) array
        Seconds.
    states : (T, 3) array
        x and y in metres and heading in radians, NaN where that is unknown.
    """

    name: str
    t: Floats
    states: Floats


def joined(tracks: list[Track], where: str, notes: list[str]) -> Found:
    """Put robots with times of their own on a common clock.

    Parameters
    ----------
    tracks : list of Track
        One a robot.
    where : str
        File name for messages.
    notes : list of str
        How it was read, to be added to.

    Raises
    ------
    LogError
        Where a robot has fewer than two samples, or robots were not seen at the same time.
    """
    sorted_tracks = [_in_order(track, where) for track in tracks]
    steps = [float(np.median(np.diff(track.t))) for track in sorted_tracks]
    first = max(float(track.t[0]) for track in sorted_tracks)
    last = min(float(track.t[-1]) for track in sorted_tracks)
    step = max(steps)
    if last - first < 2 * step:
        raise LogError(
            f"{where}: the robots' times do not overlap: the last one begins at {first:.3f} s, the "
            f"first one ends at {last:.3f} s; are they of one run, and of one clock?"
        )
    if (last - first) / step > MOST_SAMPLES:
        raise LogError(f"{where}: {last - first:g} s in steps of {step:g} s are no run")
    t: Floats = first + step * np.arange(int((last - first) / step) + 1, dtype=float)
    poses = np.stack([_at(track, t, own) for track, own in zip(sorted_tracks, steps, strict=True)])
    names = ", ".join(track.name for track in sorted_tracks[:20])
    notes.append(
        f"{len(tracks)} robots with times of their own ({names}), resampled on a common clock, "
        f"{step:.3g} s apart, for the {last - first:.1f} s in which all are seen"
    )
    return Found(t, poses.transpose(1, 2, 0), ())


def _in_order(track: Track, where: str) -> Track:
    """Sort by time; of samples at one time, the last is taken."""
    finite = np.isfinite(track.t)
    t, index = np.unique(track.t[finite][::-1], return_index=True)
    if len(t) < 2:
        raise LogError(f"{where}: robot {track.name} has {len(t)} sample(s); expected at least 2")
    return Track(track.name, t, track.states[finite][::-1][index])


def _at(track: Track, t: Floats, step: float) -> Floats:
    """Return a robot's states (T, 3) at other times, NaN where it was not seen."""
    states = track.states.copy()
    states[:, 2] = np.unwrap(states[:, 2])
    values = np.stack([np.interp(t, track.t, column) for column in states.T], axis=1)
    after = np.clip(np.searchsorted(track.t, t), 1, len(track.t) - 1)
    unseen = track.t[after] - track.t[after - 1] > GAP_FACTOR * max(
        step, float(np.median(np.diff(t)))
    )
    values[unseen & ~np.isin(t, track.t)] = np.nan
    return values
