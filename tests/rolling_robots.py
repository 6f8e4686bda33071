"""Robots that drive on arcs, and their log in the forms in which the readers' tests need it."""

import numpy as np

from posflock_robotarium.flocking.pose_log import PoseLog

STEP = 0.033


def rolling(samples=40, robots=4):
    """Robots that drive on arcs: what real wheels do."""
    t = np.arange(samples) * STEP
    turn = np.linspace(-0.3, 0.3, robots)
    heading = np.linspace(0, 5, robots) + turn * t[:, np.newaxis]
    start = np.linspace(-1, 1, robots)
    step = (
        0.1
        * STEP
        * np.stack([np.cos(heading + 0.5 * turn * STEP), np.sin(heading + 0.5 * turn * STEP)], 1)
    )
    place = np.cumsum(step, axis=0) - step + np.stack([start, -0.5 * start])
    return t, np.concatenate([place, heading[:, np.newaxis]], axis=1)


T, POSES = rolling()


def flat(order):
    if order == "state":
        return POSES.reshape(len(POSES), -1)
    return POSES.transpose(0, 2, 1).reshape(len(POSES), -1)


def log_of(path, rows, **metadata):
    """Write a pose log without closing it: a process that was killed."""
    told = {"neighbour_radius": 0.75, **metadata}
    log = PoseLog(path, robots=4, steps=len(T), metadata=told, real_time=False)
    for k in range(rows):
        log.append(T[k], POSES[k], np.zeros((2, 4)), status="optimal", intervention=0.01)
    return log


def write(path, text):
    path.write_text(text) if isinstance(text, str) else path.write_bytes(text)
    return path
