"""What others would write: the references that benchmarks compare with.

None of them is slowed down on purpose. They are what one writes who wants it right and does not
count microseconds, in numpy where that is natural.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from rps_compat.arena import RobotModel

Certify = Callable[[np.ndarray, np.ndarray], Any]

#: Certificates: smallest distance (m), γ, top speed (m/s).
RADIUS, GAIN, SPEED = 0.15, 100.0, 0.2


def dense_certificate(boundary: tuple[float, float, float, float]) -> Certify:
    """Return the certificate as it is commonly written: rows in a loop, dense, cvxopt at 1e-2."""
    from cvxopt import matrix, sparse
    from cvxopt.solvers import qp

    options = {"show_progress": False, "reltol": 1e-2, "feastol": 1e-2, "maxiters": 50}
    x_min, x_max, y_min, y_max = boundary

    def certify(desired: np.ndarray, x: np.ndarray) -> np.ndarray:
        number = x.shape[1]
        rows = number * (number - 1) // 2 + 12 * number
        a, b = np.zeros((rows, 2 * number)), np.zeros(rows)
        count = 0
        for i in range(number - 1):
            for j in range(i + 1, number):
                error = x[:, i] - x[:, j]
                h = error[0] ** 2 + error[1] ** 2 - RADIUS**2
                a[count, [2 * i, 2 * i + 1]] = -2 * error
                a[count, [2 * j, 2 * j + 1]] = 2 * error
                b[count] = GAIN * h**3
                count += 1
        for i in range(number):
            for direction, coordinate, wall in (
                (1, 0, x_max), (-1, 0, x_min), (1, 1, y_max), (-1, 1, y_min),
            ):  # fmt: skip
                a[count, 2 * i + coordinate] = direction
                gap = direction * (wall - x[coordinate, i]) - RADIUS / 2
                b[count] = 0.4 * GAIN * gap**3
                count += 1
            for k in range(8):
                a[count, 2 * i] = np.cos(k * np.pi / 4)
                a[count, 2 * i + 1] = np.sin(k * np.pi / 4)
                b[count] = SPEED * np.cos(np.pi / 8)
                count += 1
        wish = desired.reshape((2 * number, 1), order="F")
        result = qp(
            sparse(matrix(2 * np.eye(2 * number))), matrix(-2 * wish), matrix(a), matrix(b),
            options=options,
        )["x"]  # fmt: skip
        return np.reshape(result, (2, number), order="F")

    return certify


def plain_step(
    poses: np.ndarray, commands: np.ndarray, robot: RobotModel, pairs: tuple[np.ndarray, np.ndarray]
) -> tuple[bool, bool, bool]:
    """Do what one step of the simulator does, as one writes it in numpy; moves `poses` in place.

    Wheels cut at their limit, robots outside and pairs too close looked for, one Euler step.
    """
    (v, w), (x, y, theta) = commands, poses
    radius, axle, limit = robot.wheel_radius, robot.base_length, robot.max_wheel_velocity
    wheels = np.array([2 * v - axle * w, 2 * v + axle * w]) / (2 * radius)
    fast = bool(np.any(np.abs(wheels) > limit))
    left, right = np.clip(wheels, -limit, limit)
    v, w = radius / 2 * (left + right), radius / axle * (right - left)
    heading = np.array([np.cos(theta), np.sin(theta)])
    x_min, x_max, y_min, y_max = robot.boundaries
    outside = bool(np.any((x < x_min) | (x > x_max) | (y < y_min) | (y > y_max)))
    bodies = poses[:2] + robot.collision_offset * heading
    i, j = pairs
    close = bool(np.any(np.hypot(*(bodies[:, i] - bodies[:, j])) <= robot.collision_diameter))
    poses[:2] += robot.time_step * v * heading
    theta += robot.time_step * w
    poses[2] = np.arctan2(np.sin(theta), np.cos(theta))
    return fast, outside, close


def plain_flock(
    positions: np.ndarray, velocities: np.ndarray, steps: int, time_step: float = 0.05
) -> tuple[np.ndarray, np.ndarray]:
    """Simulate the paper's position-based flock as its formulas read, all pairs in numpy.

    Parameters
    ----------
    positions, velocities : (2, n) array
        At the start, metres and m/s.
    steps : int
        How many.
    time_step : float
        Seconds.
    """
    delta, radius, persistence, fastest, strongest = 0.5, 7.5, 0.1, 2.5, 5.0
    p, v = positions.copy(), velocities.copy()
    first = p[:, None, :] - p[:, :, None]
    for step in range(1, steps + 1):
        offset = p[:, None, :] - p[:, :, None]
        distance = np.linalg.norm(offset, axis=0)
        near = distance < radius
        np.fill_diagonal(near, False)
        number = near.sum(axis=1)
        np.fill_diagonal(distance, np.inf)
        psi = near * (1.0 - delta * number[:, None] / distance)
        phi = near * (number * max(1.0 / (step * time_step), persistence))[:, None]
        u = ((psi + phi) * offset - phi * first).sum(axis=2)
        v = _saturated(v + time_step * _saturated(u, strongest), fastest)
        p = p + time_step * v
    return p, v


def _saturated(vectors: np.ndarray, most: float) -> np.ndarray:
    length = np.maximum(np.linalg.norm(vectors, axis=0), 1e-300)
    return vectors * (most * np.tanh(length / most) / length)
