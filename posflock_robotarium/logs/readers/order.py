"""Rows in the order of their times, each time once, and each frame of the camera once.

Packets overtake each other, loggers write a row twice, loops are faster than cameras.  What is done
about it is told; a clock that begins anew is none of these, and refused with its row.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.logs.held import repeated_frames
from posflock_robotarium.logs.readers.found import Found

Floats = NDArray[np.float64]

_FEW = 0.1
"""Share of rows at the time of another one up to which these are damage, and one of two is kept."""


def in_order(found: Found) -> Found:
    """Sort rows by their times where that makes robots' ways shorter, and say so.

    Parameters
    ----------
    found : Found
        Poses with the file's times, if it has any.
    """
    t = found.t
    if t is None or len(t) != len(found.poses) or len(t) < 3 or not np.isfinite(t).all():
        return found
    back = int((np.diff(t) < 0).sum())
    if not back:
        return found
    order = np.argsort(t, kind="stable")
    if not _way(found.poses[order]) < _way(found.poses):
        return found  # not one run, or no times
    sorted_rows = found.rows(order)
    return sorted_rows.noted(f"{back} rows came before earlier ones: sorted by their times")


def one_row_a_time(found: Found) -> Found:
    """Keep the last of rows at exactly one time, where these are few, and say so.

    Parameters
    ----------
    found : Found
        Poses with times in their order.
    """
    t = found.t
    if t is None or len(t) != len(found.poses) or len(t) < 3:
        return found
    again = np.concatenate([t[1:] == t[:-1], [False]])  # a difference of infinities is no number
    if not again.any() or again.mean() > _FEW:
        return found
    told = f"{int(again.sum())} rows at the time of the next one are left out"
    return found.rows(~again).noted(told)


def one_row_a_frame(found: Found) -> Found:
    """Drop rows that show no new frame of the camera, and say so.

    Parameters
    ----------
    found : Found
        Poses in seconds, m and rad. With commands nothing is dropped: these were sent all the same.
    """
    if found.commands is not None or len(found.poses) < 3:
        return found
    poses = np.array(found.poses, dtype=float)
    if poses.shape[2] > 1:  # all in one place: a marker for robots that are lost is no old frame
        poses[(poses == poses[:, :, :1]).all(axis=(1, 2))] = np.nan
    with np.errstate(all="ignore"):  # what is no number yet is looked at later
        repeated = repeated_frames(poses)
    if not repeated.any():
        return found
    told = f"{int(repeated.sum())} of {len(repeated)} rows repeat an earlier frame: dropped"
    return replace(found.rows(~repeated), notes=(*found.notes, told))


def _way(poses: Floats) -> float:
    """Return how far robots go in all, m, leaving out what is missing."""
    with np.errstate(all="ignore"):
        steps = np.hypot(*np.diff(poses[:, :2], axis=0).transpose(1, 0, 2))
    return float(steps[np.isfinite(steps)].sum())
