"""JaxRobotarium in a process of its own: times what it is told on its standard input.

Started by `batch_speed.py` with the Python of an environment that has jax and jaxopt, and the
folder of the simulator (``rps_jax`` of shalin-jain/robotarium_python_simulator). A line is
``kind mode teams steps times``; the answer is ``seconds clearance violation``: CPU seconds of so
many equal rollouts that are compiled already; the least distance of two projection points less the
radius at their end, m; and how far the certificate's answer there breaks the row of a pair, m/s.
Rows are of unit norm and without the disturbance that it allows for, which would break them more.
"""

from __future__ import annotations

import os
import sys
import time

os.environ.setdefault("JAX_PLATFORMS", "cpu")
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
sys.path.insert(0, sys.argv[1])

import jax
import jax.numpy as jnp
import numpy as np
from batch_teams import AHEAD, GAIN, RADIUS, ROBOTS, SPEED, teams
from rps_jax.robotarium import Robotarium
from rps_jax.utilities.barrier_certificates2 import create_robust_barriers

_SIMULATOR = Robotarium(ROBOTS, False, False, jnp.zeros((3, ROBOTS)))
_GAIN = 150.0  # its own
_BARRIER = create_robust_barriers(safety_radius=RADIUS, gamma=_GAIN)


def to_goals(poses, goals):
    """Return unicycle commands (2, N) to goals, as `rps_compat.batch.ToGoals` wishes."""
    heading = jnp.stack([jnp.cos(poses[2]), jnp.sin(poses[2])])
    way = GAIN * (goals - poses[:2] - AHEAD * heading)
    length = jnp.sqrt((way * way).sum(axis=0))
    way = way * jnp.where(length > SPEED, SPEED / jnp.maximum(length, SPEED), 1.0)
    across = heading[0] * way[1] - heading[1] * way[0]
    return jnp.stack([(heading * way).sum(axis=0), across / AHEAD])


def stepper(kind):
    """Return what one step of one team does."""

    def step(poses, target):
        if kind == "bare":
            return _SIMULATOR.batch_step(poses, target)
        return _SIMULATOR.batch_step(poses, _BARRIER(to_goals(poses, target), poses))

    return step


def compiled(kind, mode, steps):
    """Return a call that does so many steps of all teams."""
    step = stepper(kind)
    if mode == "single":
        once = jax.jit(jax.vmap(step))

        def run(poses, targets):
            for _ in range(steps):
                poses = once(poses, targets).block_until_ready()
            return poses

        return run

    def roll(poses, target):
        return jax.lax.scan(lambda p, _: (step(p, target), None), poses, None, steps)[0]

    rolled = jax.jit(jax.vmap(roll))
    return lambda poses, targets: rolled(poses, targets).block_until_ready()


def least_clearance(poses):
    """Return the least distance of two projection points of a team less the radius, m."""
    poses = np.asarray(poses, dtype=float)
    points = poses[:, :2] + AHEAD * np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])], axis=1)
    i, j = np.triu_indices(ROBOTS, 1)
    return float(np.hypot(*np.swapaxes(points[:, :, i] - points[:, :, j], 0, 1)).min() - RADIUS)


def largest_violation(kind, poses, targets):
    """Return the largest excess over the rows of pairs of what is answered, m/s."""
    if kind == "bare":
        return float("nan")
    safe = jax.jit(jax.vmap(lambda pose, goals: _BARRIER(to_goals(pose, goals), pose)))
    poses, (v, w) = np.asarray(poses, float), np.moveaxis(np.asarray(safe(poses, targets)), 1, 0)
    heading = np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])])
    points = np.moveaxis(poses[:, :2], 1, 0) + AHEAD * heading
    velocity = v * heading + AHEAD * w * np.stack([-heading[1], heading[0]])
    i, j = np.triu_indices(ROBOTS, 1)
    way, pace = points[..., i] - points[..., j], velocity[..., i] - velocity[..., j]
    square = (way * way).sum(axis=0)
    excess = -2.0 * (way * pace).sum(axis=0) - _GAIN * (square - RADIUS**2) ** 3
    return float(np.max(excess / np.sqrt(8.0 * square)))


def main():
    """Answer until the input ends."""
    ready = {}
    print(jax.__version__, flush=True)
    for line in sys.stdin:
        kind, mode, number, steps, times = line.split()
        key = (kind, mode, int(number), int(steps))
        if key not in ready:
            arrays = [jnp.asarray(a) for a in teams(kind, key[2])]
            ready[key] = (compiled(kind, mode, key[3]), arrays)
            ready[key][0](*arrays)
        run, arrays = ready[key]
        before = time.process_time()
        for _ in range(int(times)):
            poses = run(*arrays)
        seconds = time.process_time() - before
        print(
            seconds, least_clearance(poses), largest_violation(kind, poses, arrays[1]), flush=True
        )


if __name__ == "__main__":
    main()
