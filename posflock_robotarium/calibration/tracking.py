"""What poses alone say of the tracker: heading offsets and the jitter across the heading."""

from __future__ import annotations

import math

import numpy as np

from posflock_robotarium.calibration.estimate import Estimate, Z
from posflock_robotarium.logs.run import Run
from rps_compat.kinematics import wrap


def heading_offsets(log: Run) -> tuple[Estimate, ...]:
    """Estimate by how much each tracked heading is off the course driven.

    Motion over half a second, across and along the mean tracked heading: the slope is minus the
    offset. A second regressor, the turn meanwhile, takes up how a turning robot's course relates
    to its headings at the frames. Blocks do not overlap, so their scatter gives the interval.

    Parameters
    ----------
    log : Run
        Poses over time, of robots that drove.
    """
    block = 15
    starts = np.arange(0, len(log.t) - block, block)
    out = []
    for robot in range(log.robots):
        x, y, theta = log.poses[:, :, robot].T
        heading = np.unwrap(theta)
        dx, dy = x[starts + block] - x[starts], y[starts + block] - y[starts]
        mean = np.array([heading[s : s + block + 1].mean() for s in starts])
        along = dx * np.cos(mean) + dy * np.sin(mean)
        across = dy * np.cos(mean) - dx * np.sin(mean)
        if np.abs(along).max() < 0.01:  # it never moved a centimetre
            out.append(Estimate(0.0, -math.pi, math.pi))
            continue
        design = np.stack([along, along * (heading[starts + block] - heading[starts])], axis=1)
        normal = np.linalg.pinv(design.T @ design)
        slope = normal @ design.T @ across
        error = across - design @ slope
        robust = normal @ (design.T * error**2) @ design @ normal
        out.append(Estimate.around(-math.atan(float(slope[0])), math.sqrt(float(robust[0, 0]))))
    return tuple(out)


def lateral_jitter(log: Run) -> Estimate:
    """Estimate the jitter across the heading from second differences, which smooth motion has not.

    A robot cannot go sideways, and in three frames its path bends by next to nothing.

    Parameters
    ----------
    log : Run
        Poses over time.
    """
    second = np.diff(log.poses[:, :2], n=2, axis=0)
    theta = log.poses[1:-1, 2]
    turn = wrap(log.poses[2:, 2] - log.poses[:-2, 2]) / 2
    moved = np.linalg.norm(log.poses[2:, :2] - log.poses[:-2, :2], axis=1) / 2
    across = -second[:, 0] * np.sin(theta) + second[:, 1] * np.cos(theta) - moved * turn
    variance = np.square(across) / 6
    mean = float(variance.mean())
    spread = float(variance.std() / math.sqrt(variance.size / 3))
    return Estimate(
        math.sqrt(mean),
        math.sqrt(max(0.0, mean - Z * spread)),
        math.sqrt(mean + Z * spread),
    )
