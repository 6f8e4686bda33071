"""A testbed whose imperfections are known: robots under random commands, with steps of real length.

Written apart from the arena and from what is calibrated: the equations of the model are integrated
in pieces of at most 10 ms, between the moments at which commands take effect.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from posflock_robotarium.logs.run import Run
from rps_compat.motor_effects import OFF_SPEED, OFF_TURN
from rps_compat.testbed import TIME_STEP, WATCHDOG

_PIECE = 0.010
#: Standard deviations: m/s and rad/s of each step; m along, m across, rad of each pose.
DISTURBANCE, JITTER = (0.0017, 0.0175), (0.0005, 0.0003, 0.0013)


@dataclass(frozen=True)
class Truth:
    """The imperfections of one testbed.

    Attributes
    ----------
    dead_time, lag : float
        Of the team, s.
    speed_gain, turn_gain : (N,) array
        Factors.
    turn_bias : (N,) array
        rad/s.
    heading_offset : (N,) array
        rad.
    """

    dead_time: float
    lag: float
    speed_gain: np.ndarray
    turn_gain: np.ndarray
    turn_bias: np.ndarray
    heading_offset: np.ndarray


def random_truth(rng: np.random.Generator, robots: int) -> Truth:
    """Draw the imperfections of a testbed."""
    return Truth(
        dead_time=float(rng.uniform(0.1, 0.3)),
        lag=float(rng.uniform(0.08, 0.25)),
        speed_gain=rng.uniform(0.9, 1.1, robots),
        turn_gain=rng.uniform(0.9, 1.1, robots),
        turn_bias=rng.normal(0.0, 0.012, robots),
        heading_offset=rng.uniform(-0.03, 0.03, robots),
    )


def real_steps(rng: np.random.Generator, rows: int) -> np.ndarray:
    """Draw step times as measured on ten hardware runs of 2022, s.

    The median was 33.1 ms, the mean 34.6 to 35.8 ms. Every 144 steps or so the loop stalled for
    0.3 s and made two short steps after it; 3 of 10 runs had one stall of up to 2.6 s.
    """
    steps = rng.normal(0.0331, 0.0006, rows)
    slow = rng.random(rows) < 0.1
    steps[slow] = rng.normal(0.0331, 0.0025, int(slow.sum()))
    stalls = np.arange(int(rng.integers(1, 144)), rows - 2, 144)
    stalls = stalls[rng.random(len(stalls)) > 0.06]
    for after, (mean, spread) in enumerate([(0.3065, 0.002), (0.0047, 0.0004), (0.0185, 0.0018)]):
        steps[stalls + after] = rng.normal(mean, spread, len(stalls))
    if rng.random() < 0.3:
        steps[rng.integers(rows)] = rng.uniform(0.4, 2.6)
    return np.maximum(steps, 0.004)


def random_commands(rng: np.random.Generator, rows: int, robots: int) -> np.ndarray:
    """Draw commands (rows, 2, robots) that are held for one to two seconds."""
    commands = np.zeros((rows, 2, robots))
    for robot in range(robots):
        row = 0
        while row < rows:
            length = int(rng.integers(20, 60))
            speeds = rng.uniform(-0.12, 0.15), rng.uniform(-1.0, 1.0)
            commands[row : row + length, :, robot] = speeds
            row += length
    return commands


def drive(
    t: np.ndarray, commands: np.ndarray, truth: Truth, rng: np.random.Generator
) -> np.ndarray:
    """Return the tracked poses (T, 3, N) of robots that start at rest, facing along x."""
    robots = commands.shape[2]
    told = [(at, command) for at, command in zip(t, commands, strict=True)]
    # Robots that have heard nothing for a while brake.
    told += [(at + WATCHDOG, 0 * commands[0]) for at in t[:-1][np.diff(t) > WATCHDOG]]
    told.sort(key=lambda entry: float(entry[0]))
    heard = np.array([at for at, _ in told]) + truth.dead_time
    pose, speed = np.zeros((3, robots)), np.zeros((2, robots))
    poses = [pose.copy()]
    scale = np.array(DISTURBANCE)[:, None]
    for start, end in pairwise(t):
        inside = heard[(heard > start) & (heard < end)]
        moments = np.concatenate([[start], inside, [end]])
        noise = scale * rng.standard_normal((2, robots))
        for first, last in pairwise(moments):
            which = int(np.searchsorted(heard, (first + last) / 2)) - 1
            aim = told[which][1] if which >= 0 else 0 * speed
            parts = int(np.ceil((last - first) / _PIECE))
            for _ in range(parts):
                pose, speed = _piece(pose, speed, aim, (last - first) / parts, truth, noise)
        poses.append(pose.copy())
    return _tracked(np.array(poses), truth, rng)


def _piece(
    pose: np.ndarray,
    speed: np.ndarray,
    aim: np.ndarray,
    length: float,
    truth: Truth,
    noise: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Drive for a moment in which the input does not change."""
    left = np.exp(-length / truth.lag)
    mean = aim + (speed - aim) * truth.lag / length * (1 - left)
    on = (np.abs(mean[0]) >= OFF_SPEED) | (np.abs(mean[1]) >= OFF_TURN)
    forward = truth.speed_gain * mean[0] + on * noise[0]
    turn = truth.turn_gain * mean[1] + on * (truth.turn_bias + noise[1])
    middle = pose[2] + turn * length / 2
    x = pose[0] + forward * length * np.cos(middle)
    y = pose[1] + forward * length * np.sin(middle)
    return np.stack([x, y, pose[2] + turn * length]), aim + (speed - aim) * left


def _tracked(poses: np.ndarray, truth: Truth, rng: np.random.Generator) -> np.ndarray:
    along, across, askew = np.array(JITTER)[:, None, None] * rng.standard_normal(
        (3, len(poses), poses.shape[2])
    )
    cosine, sine = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    seen = poses.copy()
    seen[:, 0] += along * cosine - across * sine
    seen[:, 1] += along * sine + across * cosine
    heading = poses[:, 2] + truth.heading_offset + askew
    seen[:, 2] = np.arctan2(np.sin(heading), np.cos(heading))
    return seen


def simulated_testbed(
    seed: int, robots: int = 4, rows: int = 1500, truth: Truth | None = None
) -> tuple[Run, Truth]:
    """Return a log with the times of its steps as they were, and what is true of its robots."""
    rng = np.random.default_rng([seed, 1])
    truth = truth or random_truth(rng, robots)
    t = np.concatenate([[0.0], np.cumsum(real_steps(rng, rows - 1))])
    commands = random_commands(rng, rows, robots)
    return Run("calibration", t, drive(t, commands, truth, rng), commands), truth


def nominal(log: Run) -> Run:
    """Return the same log as a loop writes it that counts steps instead of reading a clock."""
    return Run(log.name, TIME_STEP * np.arange(len(log.t)), log.poses, log.commands)
