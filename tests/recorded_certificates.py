"""The recorded optima of the published certificates, and their rows composed with this package.

Each case names its rows (radius, gain, walls, octagon, wheels, obstacles) and holds command, poses
and the exact optimum of the published program, whose optimality conditions were verified to 1e-9.
Needs numpy and scipy alone, so that it can be replayed wherever certificates are to run.
"""

import json
from pathlib import Path

import numpy as np

from barrier_certificates.differential_drive import DifferentialDrive
from barrier_certificates.projection import Projector
from barrier_certificates.rows import (
    Disc,
    LimitRows,
    ObstacleRows,
    PairRows,
    RowBook,
    Scene,
    VelocityPolygon,
    WallRows,
    rectangle,
)

GOLDEN = Path(__file__).parent / "golden" / "barriers.npz"


def load():
    """Return all cases as dictionaries of rows and arrays."""
    with np.load(GOLDEN) as file:
        cases, numbers = json.loads(str(file["cases"])), file["numbers"]
    place = 0
    for case in cases:
        n = case["robots"]
        shapes = {
            "command": (2, n), "poses": (case["rows"], n),
            "obstacles": (2, case["obstacles"]), "optimum": (2, n),
        }  # fmt: skip
        for name, shape in shapes.items():
            count = shape[0] * shape[1]
            case[name] = numbers[place : place + count].reshape(shape)
            place += count
    assert place == numbers.shape[0]
    return cases


def certify(case, solver):
    """Compose the rows of the published certificate and project; return in its own units."""
    command, poses, distance = case["command"], case["poses"], case.get("projection_distance")
    points, headings = poses[:2], None
    if distance is not None:
        cos, sin = headings = np.stack([np.cos(poses[2]), np.sin(poses[2])])
        points = points + distance * headings
        ahead, aside = command[0], distance * command[1]
        command = np.stack([ahead * cos - aside * sin, ahead * sin + aside * cos])
    if "scaled_to" in case:
        speed = np.maximum(np.hypot(*command), 1e-300)
        command = command * np.minimum(1.0, case["scaled_to"] / speed)
    families, disturbance = [], None
    if "octagon" in case:
        octagon = VelocityPolygon.octagon(case["octagon"])
        bounds = octagon.bounds.copy()
        bounds[0] = case.get("first_side", bounds[0])
        families.append(LimitRows(octagon.normals, bounds, octagon.names))
    if "wheels" in case:
        limit, radius, base = np.abs(case["wheels"])
        drive = DifferentialDrive(
            projection_distance=abs(distance),
            speed_limit=None,
            wheel_limit=limit,
            wheel_radius=radius,
            base_length=base,
            wheel_disturbance=abs(case["disturbance"]),
        )
        families.append(drive.polygon().rows(turning=True))
        disturbance = drive.disturbance()
    if "boundary" in case:
        walls = rectangle(case["boundary"])
        families.append(WallRows(*walls, case["radius"] / 2, case["gain"]))
    if case["obstacles"].size:
        discs = [Disc((x, y), 0.0) for x, y in case["obstacles"].T]
        families.append(ObstacleRows(discs, case["radius"], case["gain"], disturbance))
    pairs = PairRows(case["radius"], case["gain"], case.get("unsafe_gain"), disturbance)
    rows, _ = RowBook(families, pairs).write(Scene(points, headings))
    velocity, info = Projector(solver).project(command, rows)
    if distance is not None:
        x, y = velocity
        velocity = np.stack([x * cos + y * sin, (y * cos - x * sin) / distance])
        if "turn_rate_clip" in case:
            clip = case["turn_rate_clip"]
            velocity[1] = np.clip(velocity[1], -clip, clip)
    return velocity, info


def check(case, solver):
    """Raise AssertionError unless the recorded optimum is reproduced."""
    velocity, info = certify(case, solver)
    assert info.status in ("trivial", "optimal"), case["id"]
    # A few recorded probes are of up to 1400 km/s; there figures are relative.
    scale = max(1.0, np.abs(case["optimum"]).max())
    assert info.violation <= 1e-9 * scale, case["id"]
    assert np.abs(velocity - case["optimum"]).max() <= 1e-8 * scale, case["id"]
