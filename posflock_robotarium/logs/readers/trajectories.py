"""Trajectories of one body in space: the TUM format and EuRoC's ground truth.

Both have a time, a place and a quaternion in each row, TUM with blanks, seconds and the real part
last, EuRoC with commas, nanoseconds and the real part first, under a header. Seen from above, they
are a robot's x, y and heading.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.forms import Form, Sign
from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.readers.quaternions import are_unit, headings_of
from posflock_robotarium.logs.readers.tables import read_table

Floats = NDArray[np.float64]


def _is_tum(file: Path, start: bytes) -> bool:
    """Whether whole rows of eight numbers end in a quaternion."""
    if _is_euroc(file, start):
        return False
    lines = [line for line in start.splitlines()[:-1] if line and not line.startswith(b"#")]
    try:
        rows = [[float(cell) for cell in line.replace(b",", b" ").split()] for line in lines]
    except ValueError:
        return False
    if not rows or any(len(row) != 8 for row in rows):
        return False
    return are_unit(np.array(rows)[:, 4:])


def _read_tum(file: Path, options: ReadOptions) -> Found:
    values = _rows(file, options, 8)
    return _one_robot(values[:, 0], values, values[:, 4:8].T, "TUM trajectory")


def _is_euroc(file: Path, start: bytes) -> bool:
    head = start.splitlines()[0].lower().replace(b" ", b"") if start else b""
    return head.startswith(b"#timestamp") and b"p_rs_r_x" in head and b"q_rs_w" in head


def _read_euroc(file: Path, options: ReadOptions) -> Found:
    values = _rows(file, options, 8)
    rotations = values[:, [5, 6, 7, 4]].T
    return _one_robot(values[:, 0] * 1e-9, values, rotations, "EuRoC ground truth, time in ns")


def _rows(file: Path, options: ReadOptions, least: int) -> Floats:
    values = read_table(file, options.bounds).values
    if values.shape[1] < least:
        raise LogError(f"{file}: {values.shape[1]} columns, expected {least}")
    return values


def _one_robot(t: Floats, values: Floats, rotations: Floats, what: str) -> Found:
    """Return one robot, seen from above, and what of it that leaves out."""
    heading, told = headings_of(rotations)
    notes = [f"{what}: one robot, heading from the quaternion{told}"]
    if len(values) and (rise := float(np.ptp(values[:, 3]))) > 0.05:
        notes.append(f"its height changes by {rise:.3g} m: left out")
    poses = np.stack([values[:, 1], values[:, 2], heading], axis=1)[:, :, np.newaxis]
    return Found(t, poses, tuple(notes), lengths_told=True, angles_told=True)


TUM = Form(
    name="tum",
    label="TUM",
    summary="time, place and quaternion of one robot",
    told_by=Sign.CONTENT,
    recognises=_is_tum,
    read=_read_tum,
)
EUROC = Form(
    name="euroc",
    label="EuRoC",
    summary="ground truth CSV of one robot, nanoseconds",
    told_by=Sign.CONTENT,
    recognises=_is_euroc,
    read=_read_euroc,
)
