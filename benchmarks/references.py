"""What others would write: the references that benchmarks compare with.

None of them is slowed down on purpose. They are what one writes who wants it right and does not
count microseconds, in numpy where that is natural.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from rps_compat.testbed import RobotModel

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


def sparse_certificate(boundary: tuple[float, float, float, float]) -> Certify:
    """Return the certificate as an expert writes it for many robots: sparse, near pairs, OSQP.

    Pairs out of reach of each other are left out; the rest is assembled without a Python loop. OSQP
    is set up for each state, since the pairs change, and started from the last answer.
    """
    import osqp
    from scipy import sparse
    from scipy.spatial import cKDTree

    x_min, x_max, y_min, y_max = boundary
    angles = np.arange(8) * np.pi / 4
    octagon = np.stack([np.cos(angles), np.sin(angles)])
    # Two robots at full speed cannot break a row from farther apart than this.
    far = np.linspace(RADIUS, 3.0, 10_000)
    reach = far[np.argmax(GAIN * (far**2 - RADIUS**2) ** 3 >= 4.0 * SPEED * far)]
    last: list[np.ndarray | None] = [None]

    def certify(desired: np.ndarray, x: np.ndarray) -> np.ndarray:
        number = x.shape[1]
        i, j = cKDTree(x.T).query_pairs(reach, output_type="ndarray").T
        offset = x[:, i] - x[:, j]
        row = np.arange(len(i))
        robots = np.arange(number)
        blocks = [
            sparse.csc_matrix(
                (
                    np.concatenate([-2 * offset[0], -2 * offset[1], 2 * offset[0], 2 * offset[1]]),
                    (np.tile(row, 4), np.concatenate([2 * i, 2 * i + 1, 2 * j, 2 * j + 1])),
                ),
                (len(i), 2 * number),
            ),
            sparse.kron(sparse.identity(number), octagon.T),
            sparse.identity(2 * number),
        ]
        gap_up = np.stack([x_max - x[0], y_max - x[1]]) - RADIUS / 2
        gap_down = np.stack([x[0] - x_min, x[1] - y_min]) - RADIUS / 2
        upper = np.concatenate(
            [
                GAIN * ((offset**2).sum(axis=0) - RADIUS**2) ** 3,
                np.full(8 * number, SPEED * np.cos(np.pi / 8)),
                0.4 * GAIN * gap_up[:, robots].T.ravel() ** 3,
            ]
        )
        lower = np.full(upper.shape, -np.inf)
        lower[-2 * number :] = -0.4 * GAIN * gap_down.T.ravel() ** 3
        solver = osqp.OSQP()
        solver.setup(
            sparse.identity(2 * number, format="csc"), -desired.T.ravel(),
            sparse.vstack(blocks, format="csc"), lower, upper,
            eps_abs=1e-6, eps_rel=1e-6, max_iter=20_000, verbose=False,
        )  # fmt: skip
        if last[0] is not None and last[0].size == 2 * number:
            solver.warm_start(x=last[0])
        last[0] = solver.solve().x
        return last[0].reshape(-1, 2).T

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
