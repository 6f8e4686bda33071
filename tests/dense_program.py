"""The programs of the published certificates, written out densely and solved by another solver."""

import warnings

import numpy as np
import pytest
from hypothesis import strategies as st

cvxopt = pytest.importorskip("cvxopt")

ARENA = (-1.6, 1.6, -1.0, 1.0)

AROUND = (-1.7, 1.7, -1.1, 1.1)


class Program:
    """min ‖v − v̂‖² over rows, written out densely and solved by another solver."""

    def __init__(self, points, wanted):
        self.points, self.wanted = points, wanted
        self.robots = points.shape[1]
        self.rows, self.bounds = [], []

    def row(self, entries, bound):
        dense = np.zeros((self.robots, 2))
        for robot, direction in entries:
            dense[robot] = direction
        self.rows.append(dense.ravel())
        self.bounds.append(bound)

    def pairs(self, radius, gain, unsafe=None, loss=None):
        for i in range(self.robots):
            for j in range(i + 1, self.robots):
                offset = self.points[:, i] - self.points[:, j]
                h = offset @ offset - radius**2
                firmness = unsafe if unsafe is not None and h < 0 else gain
                lost = 0 if loss is None else loss(i, 2 * offset) + loss(j, 2 * offset)
                self.row([(i, -2 * offset), (j, 2 * offset)], firmness * h**3 - lost)
        return self

    def obstacles(self, points, radius, gain, loss):
        for i in range(self.robots):
            for point in points.T:
                offset = self.points[:, i] - point
                bound = gain * (offset @ offset - radius**2) ** 3 - loss(i, 2 * offset)
                self.row([(i, -2 * offset)], bound)
        return self

    def walls(self, arena, radius, gain):
        x_min, x_max, y_min, y_max = arena
        for i, (x, y) in enumerate(self.points.T):
            for normal, gap in (
                ((1, 0), x_max - x),
                ((-1, 0), x - x_min),
                ((0, 1), y_max - y),
                ((0, -1), y - y_min),
            ):
                self.row([(i, normal)], 0.4 * gain * (gap - radius / 2) ** 3)
        return self

    def octagon(self, limit, first_side=None):
        for i in range(self.robots):
            for k in range(8):
                angle = k * np.pi / 4
                side = first_side if k == 0 and first_side else limit * np.cos(np.pi / 8)
                self.row([(i, (np.cos(angle), np.sin(angle)))], side)
        return self

    def wheels(self, to_wheels, limit):
        for i in range(self.robots):
            for wheel in (0, 1):
                for sign in (1, -1):
                    self.row([(i, sign * to_wheels(i)[wheel])], limit)
        return self

    def solve(self):
        if not self.rows:
            return self.wanted
        rows, bounds = np.array(self.rows), np.array(self.bounds)
        lengths = np.linalg.norm(rows, axis=1)
        target = self.wanted.T.ravel()
        answer = cvxopt.solvers.qp(
            cvxopt.matrix(np.eye(target.size)),
            cvxopt.matrix(-target),
            cvxopt.matrix(rows / lengths[:, None]),
            cvxopt.matrix(bounds / lengths),
            options={"show_progress": False, "abstol": 1e-12, "reltol": 1e-11, "feastol": 1e-11},
        )
        return np.array(answer["x"]).reshape(-1, 2).T if answer["status"] == "optimal" else None


def clipped(velocities, limit):
    speed = np.maximum(np.hypot(*velocities), 1e-300)
    return velocities * np.minimum(1, limit / speed)


def ahead(poses, distance):
    return poses[:2] + distance * np.array([np.cos(poses[2]), np.sin(poses[2])])


def to_point(commands, poses, distance):
    cos, sin = np.cos(poses[2]), np.sin(poses[2])
    v, w = commands
    return np.array([cos * v - distance * sin * w, sin * v + distance * cos * w])


def to_command(velocities, poses, distance):
    cos, sin = np.cos(poses[2]), np.sin(poses[2])
    x, y = velocities
    return np.array([cos * x + sin * y, (cos * y - sin * x) / distance])


class Wheels:
    """Wheel speeds as functions of the velocity of the point ahead."""

    def __init__(self, poses, distance, radius=0.016, base=0.105):
        to_body = np.array([[radius / 2, radius / 2], [-radius / base, radius / base]])
        self.to_point = [
            np.array([[np.cos(t), -distance * np.sin(t)], [np.sin(t), distance * np.cos(t)]])
            @ to_body
            for t in poses[2]
        ]

    def inverse(self, robot):
        return np.linalg.inv(self.to_point[robot])

    def loss(self, disturbance):
        return lambda robot, row: disturbance * np.abs(row @ self.to_point[robot]).sum()


@st.composite
def teams(draw):
    robots = draw(st.integers(2, 6))
    rng = np.random.default_rng(draw(st.integers(0, 2**31 - 1)))
    spread = draw(st.sampled_from([0.3, 0.8]))
    poses = np.vstack([rng.uniform(-spread, spread, (2, robots)), rng.uniform(-3, 3, robots)])
    poses[0] *= draw(st.sampled_from([1.0, 1.9]))
    return poses, rng.normal(0, 0.2, (2, robots)), rng.normal(0, 1, robots)


def check(answer, program, expected=lambda v: v, tolerance=2e-6):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        safe = answer()
    assert np.isfinite(safe).all()
    optimum = program.solve()
    if optimum is not None:
        np.testing.assert_allclose(safe, expected(optimum), atol=tolerance, rtol=1e-5)
