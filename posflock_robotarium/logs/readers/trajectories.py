"""Trajectories of one body in space: the TUM format, EuRoC's ground truth and KITTI's matrices.

The first two have a time, a place and a quaternion in each row, TUM with blanks, seconds and the
real part last, EuRoC with commas, nanoseconds and the real part first, under a header. KITTI's rows
have no time, and are often of a camera. Seen from above, they are a robot's x, y and heading.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.forms import Form, Sign
from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.readers.quaternions import MOST_TILTED, are_unit, headings_of
from posflock_robotarium.logs.readers.rotations import are_matrices
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


def _is_kitti(file: Path, start: bytes) -> bool:
    """Whether whole rows of twelve numbers are the upper rows of rigid motions."""
    lines = [line for line in start.splitlines()[:-1] if line and not line.startswith(b"#")]
    try:
        rows = [[float(cell) for cell in line.replace(b",", b" ").split()] for line in lines]
    except ValueError:
        return False
    return bool(rows) and all(len(row) == 12 for row in rows) and are_matrices(np.array(rows))


def _read_kitti(file: Path, options: ReadOptions) -> Found:
    """Read a body's motions: over a floor below its z axis, or a camera's, with y down."""
    motions = _rows(file, options, 12).reshape(-1, 3, 4)
    what = "KITTI poses, 3×4 matrices: one robot"
    if _turns_about(motions, 1) and not _turns_about(motions, 2):
        what += ", in a camera's frame (z ahead, x to the right, y down): the floor is z and -x"
        motions = _FROM_CAMERA @ motions @ _AND_BACK
    heading = np.arctan2(motions[:, 1, 0], motions[:, 0, 0])
    if not _turns_about(motions, 2):
        what += ", which tilts as no robot on a floor does: headings are left out"
        heading = np.full(len(motions), np.nan)
    poses = np.stack([motions[:, 0, 3], motions[:, 1, 3], heading], axis=1)[:, :, np.newaxis]
    return Found(None, poses, (what,), lengths_told=True, angles_told=True)


def _turns_about(motions: Floats, axis: int) -> bool:
    """Whether a body keeps one of its axes where it was, nearly and most of the time."""
    return bool(np.quantile(motions[:, axis, axis], 0.1) >= np.cos(MOST_TILTED))


_FROM_CAMERA = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""From x to the right, y down and z ahead to x ahead, y to the left and z up."""
_AND_BACK = np.block([[_FROM_CAMERA.T, np.zeros((3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]])


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
KITTI = Form(
    name="kitti",
    label="KITTI",
    summary="rows of 3×4 matrices of one robot, or of a camera on it; `--dt` says the step",
    told_by=Sign.CONTENT,
    recognises=_is_kitti,
    read=_read_kitti,
)
