"""Poses that are no new ones: a frame that was written again, or a tracker that held its last pose.

A pose that is equal to the one before it, to the last bit, is one of two things: a robot that
stands, in a simulation without noise; or an old pose.  It is an old one where

- the log jitters: a tracker never sees the same place twice, to the last bit;
- the robot catches up: its next new pose is as far away as it had gone on driving meanwhile;
- the whole team holds again and again, for a few rows each time: the loop outruns the camera.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]

#: Metres of jitter across the heading that no simulation without noise has.
_JITTER = 2e-5
#: How many times what the log rounds its numbers to jitter must be, to be none of that.
_ROUNDED = 2.0
#: Share of equal poses of a robot whose own jitter cannot be told.
_NEVER_NEW = 0.95
#: Rows around a held pose by which it is judged whether the robot drove meanwhile.
_AROUND = 15
#: New poses around it without which nothing is told.
_FEWEST = 3
#: A camera slower than the loop: so many stretches, so short, for so much of the log.
_STRETCHES, _SHORT, _OFTEN = 10, 4, 0.25


def held_poses(poses: Floats) -> Booleans:
    """Tell which poses are old ones.

    Parameters
    ----------
    poses : (T, 3, N) array
        Poses, m and rad; NaN where a robot was not seen.

    Returns
    -------
    (T, N) boolean array
        Whether a robot's pose is one that it had before, and not where it was then.
    """
    same = np.zeros((len(poses), poses.shape[2]), dtype=bool)
    steps = np.diff(poses, axis=0)
    unheaded = np.isnan(steps[:, 2]) & np.isfinite(steps[:, 0])
    same[1:] = (steps[:, :2] == 0).all(axis=1) & ((steps[:, 2] == 0) | unheaded)
    if not same.any():
        return same
    slow_camera = _camera_is_slow(same, np.isfinite(poses[:, 0]))
    held = same & slow_camera[:, np.newaxis]
    jitters = [_jitters(poses[:, :, n], same[:, n]) for n in range(same.shape[1])]
    for robot in np.flatnonzero((same & ~held).any(axis=0)):
        # What is seen of a robot that never moves is told by the others: one tracker sees all.
        never = same[1:, robot].mean() > _NEVER_NEW
        if jitters[robot] or (never and any(jitters)):
            held[:, robot] = same[:, robot]
            continue
        stretches = stretches_of(same[:, robot] & ~slow_camera)
        caught_up = _catches_up(poses[:, :2, robot], same[:, robot], stretches)
        for rows, is_old in zip(stretches, caught_up.tolist(), strict=True):
            held[rows, robot] = is_old
    return held


def repeated_frames(poses: Floats) -> Booleans:
    """Tell which rows say nothing new of anybody.

    Parameters
    ----------
    poses : (T, 3, N) array
        Poses, m and rad; NaN where a robot was not seen.

    Returns
    -------
    (T,) boolean array
        Whether all robots that are seen in a row hold old poses.
    """
    return nobody_new(held_poses(poses), np.isfinite(poses[:, 0]))


def nobody_new(held: Booleans, seen: Booleans) -> Booleans:
    """Tell in which rows all robots that are seen hold old poses.

    Parameters
    ----------
    held : (T, N) boolean array
        Which poses are old ones.
    seen : (T, N) boolean array
        Which poses are there.

    Returns
    -------
    (T,) boolean array
        Whether there is a pose in the row, and no new one.
    """
    return np.asarray(held.any(axis=1) & ~(seen & ~held).any(axis=1), dtype=bool)


def _camera_is_slow(same: Booleans, seen: Booleans) -> Booleans:
    """Return the rows in which the whole team holds its poses, as it does again and again."""
    all_same = nobody_new(same, seen)
    short = [rows for rows in stretches_of(all_same) if rows.stop - rows.start <= _SHORT]
    held: Booleans = np.zeros(len(same), dtype=bool)
    if len(short) >= _STRETCHES:
        for rows in short:
            held[rows] = True
    if held.sum() < _OFTEN * len(same):
        held[:] = False
    return held


def _jitters(poses: Floats, same: Booleans) -> bool:
    """Whether a robot's poses (T, 3) scatter across its heading, as only tracked ones do."""
    moved, turned = np.diff(poses[:, :2], axis=0), np.diff(poses[:, 2])
    new = ~same[1:] & np.isfinite(turned)
    if new.sum() < _AROUND:
        return False
    # A simulator goes along the heading of the row before, or along that in the middle.
    across = [
        np.abs(moved[new, 1] * np.cos(angle) - moved[new, 0] * np.sin(angle))
        for angle in (poses[:-1, 2][new], poses[:-1, 2][new] + turned[new] / 2)
    ]
    jitter = float(np.median(np.minimum(*across)))
    return jitter > max(_JITTER, _ROUNDED * _rounding(poses[np.isfinite(poses[:, 0]), 0]))


def _rounding(values: Floats) -> float:
    """Return what decimal numbers were rounded to, m; 0 where they were not."""
    for digits in range(1, 6):
        scaled = values * 10.0**digits
        if float(np.abs(scaled - np.rint(scaled)).max(initial=0.0)) < 1e-6:
            return float(10.0**-digits)
    return 0.0


def _catches_up(positions: Floats, same: Booleans, held: list[slice]) -> Booleans:
    """Whether a robot (T, 2) is, after each stretch of held poses, where it had gone on to."""
    first = np.array([rows.start for rows in held], dtype=int)
    last = np.array([rows.stop for rows in held], dtype=int)
    steps = np.full(len(positions), np.nan)
    steps[1:] = np.hypot(*np.diff(positions, axis=0).T)
    steps[same | ~(steps > 0)] = np.nan  # no new pose
    nothing = np.full(_AROUND, np.nan)
    padded = np.concatenate([nothing, steps, nothing, nothing])
    before = _medians(padded[first[:, np.newaxis] + np.arange(_AROUND)])
    after = _medians(padded[last[:, np.newaxis] + np.arange(_AROUND + 1, 2 * _AROUND)])
    ended = np.minimum(last, len(positions) - 1)
    caught = np.hypot(*(positions[ended] - positions[first - 1]).T)
    far = caught > (1 + (last - first) / 2) * np.fmax(before, after)
    return np.asarray(far & (last < len(positions)), dtype=bool)


def _medians(windows: Floats) -> Floats:
    """Return the median of each row (K, w) of known numbers; NaN where too few are known."""
    number = np.isfinite(windows).sum(axis=1)
    ordered = np.sort(windows, axis=1)  # NaN last
    middle = np.stack([np.maximum(number - 1, 0) // 2, number // 2], axis=1)
    pairs = np.take_along_axis(ordered, np.minimum(middle, windows.shape[1] - 1), axis=1)
    return np.where(number >= _FEWEST, pairs.mean(axis=1), np.nan)


def stretches_of(flags: Booleans) -> list[slice]:
    """Return where flags are set.

    Parameters
    ----------
    flags : (T,) boolean array
        Any flags, one a row.

    Returns
    -------
    list of slice
        Rows of each stretch, in order.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [slice(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
