"""What poses alone say of the tracker: heading offsets and the jitter across the heading."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.calibration.estimate import Estimate, Z
from posflock_robotarium.logs.run import Run
from rps_compat.kinematics import wrap

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
#: Rows of a block over which the course driven is compared with the heading: half a second.
_BLOCK = 15


def heading_offsets(log: Run, t: Floats, known: Flags) -> tuple[Estimate, ...]:
    """Estimate by how much each tracked heading is off the course driven.

    Motion over half a second, across and along the mean tracked heading: the slope is minus the
    offset. A second regressor, the turn meanwhile, takes up how a turning robot's course relates
    to its headings at the frames. Blocks do not overlap, so their scatter gives the interval.

    Parameters
    ----------
    log : Run
        Poses over time, of robots that drove.
    t : (T,) array
        Seconds of the rows.
    known : (T - 1, N) boolean array
        Which increments are to be believed.

    Returns
    -------
    tuple of Estimate
        One a robot, rad; from -π to π where it did not drive.
    """
    starts = np.arange(0, len(t) - _BLOCK, _BLOCK)
    lasted = t[starts + _BLOCK] - t[starts]
    even = lasted < 2 * np.median(lasted)
    return tuple(
        _heading_offset(log.poses[:, :, robot], t, starts[even & _all_in_blocks(known[:, robot])])
        for robot in range(log.robots)
    )


def _all_in_blocks(known: Flags) -> Flags:
    blocks = len(known) // _BLOCK
    whole: Flags = np.all(known[: blocks * _BLOCK].reshape(blocks, _BLOCK), axis=1)
    return whole


def _heading_offset(poses: Floats, t: Floats, starts: NDArray[np.intp]) -> Estimate:
    if not starts.size:
        return Estimate(0.0, -math.pi, math.pi)
    rows = starts[:, None] + np.arange(_BLOCK + 1)
    x, y = poses[rows, 0], poses[rows, 1]
    heading = np.unwrap(poses[rows, 2], axis=1)
    dx, dy = x[:, -1] - x[:, 0], y[:, -1] - y[:, 0]
    steps = np.diff(t[rows], axis=1)
    mean = (steps * (heading[:, 1:] + heading[:, :-1]) / 2).sum(axis=1) / steps.sum(axis=1)
    along = dx * np.cos(mean) + dy * np.sin(mean)
    across = dy * np.cos(mean) - dx * np.sin(mean)
    if np.abs(along).max() < 0.01:  # it never moved a centimetre
        return Estimate(0.0, -math.pi, math.pi)
    design = np.stack([along, along * (heading[:, -1] - heading[:, 0])], axis=1)
    normal = np.linalg.pinv(design.T @ design)
    slope = normal @ design.T @ across
    error = across - design @ slope
    robust = normal @ (design.T * error**2) @ design @ normal
    return Estimate.around(-math.atan(float(slope[0])), math.sqrt(float(robust[0, 0])))


def lateral_jitter(log: Run, steps: Floats, known: Flags) -> Estimate | None:
    """Estimate the jitter across the heading from second differences, which smooth motion has not.

    A robot cannot go sideways, and in three frames its path bends by next to nothing.

    Parameters
    ----------
    log : Run
        Poses over time.
    steps : (K,) array
        Seconds from row to row.
    known : (K, N) boolean array
        Which increments are to be believed.

    Returns
    -------
    Estimate or None
        m; None where no three rows in a row are to be believed.
    """
    even = np.abs(np.diff(steps)) < 0.25 * np.median(steps)
    usable = known[1:] & known[:-1] & even[:, None]
    second = np.diff(log.poses[:, :2], n=2, axis=0)
    theta = log.poses[1:-1, 2]
    turn = wrap(log.poses[2:, 2] - log.poses[:-2, 2]) / 2
    moved = np.linalg.norm(log.poses[2:, :2] - log.poses[:-2, :2], axis=1) / 2
    across = -second[:, 0] * np.sin(theta) + second[:, 1] * np.cos(theta) - moved * turn
    variance = np.square(across[usable]) / 6
    if not variance.size:
        return None
    mean = float(variance.mean())
    spread = float(variance.std() / math.sqrt(variance.size / 3))
    return Estimate(
        math.sqrt(mean),
        math.sqrt(max(0.0, mean - Z * spread)),
        math.sqrt(mean + Z * spread),
    )
