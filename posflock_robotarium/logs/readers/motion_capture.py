"""Rigid bodies as motion capture exports them: Motive (OptiTrack) and Vicon Tracker.

Several header lines say which body a column belongs to and what it is. Motive's y axis points up:
the floor is x and -z. A body that is not seen has empty cells, and is unknown there.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.forms import Form, Sign
from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.readers.names import ANGLES, LENGTHS
from posflock_robotarium.logs.readers.quaternions import headings_of

Floats = NDArray[np.float64]

_METRES = {"meters": 1.0, "centimeters": 1e-2, "millimeters": 1e-3}


def _rows(file: Path, options: ReadOptions) -> list[list[str]]:
    options.bounds.require_size(8 * file.stat().st_size, str(file))
    with file.open(encoding="utf-8-sig", errors="replace", newline="") as stream:
        return [[cell.strip() for cell in row] for row in csv.reader(stream)]


def _numbers(file: Path, rows: list[list[str]], first: int, width: int) -> Floats:
    """Return the rows from `first` on, NaN where a cell is empty."""
    values = np.full((len(rows) - first, width), np.nan)
    for number, row in enumerate(rows[first:]):
        for column, cell in enumerate(row[:width]):
            try:
                values[number, column] = float(cell) if cell else np.nan
            except ValueError as error:
                raise LogError(
                    f"{file}: line {first + number + 1}: column {column + 1} is {cell[:40]!r}, "
                    "not a number"
                ) from error
    return values[np.isfinite(values[:, 0])] if width else values


def _read_motive(file: Path, options: ReadOptions) -> Found:
    rows = _rows(file, options)
    about = dict(zip(rows[0][::2], rows[0][1::2], strict=False))
    if about.get("Rotation Type", "Quaternion") != "Quaternion":
        raise LogError(
            f"{file}: rotations are {about['Rotation Type']}; export them again from Motive with "
            "rotation type Quaternion"
        )
    head = next((i for i, row in enumerate(rows[:12]) if row[:1] == ["Frame"]), None)
    name = next((row for row in rows[:12] if row[1:2] == ["Name"]), None)
    if head is None or head < 1 or name is None:
        raise LogError(f"{file}: a Motive export without its lines Name and Frame")
    kinds, axes = rows[head - 1], rows[head]
    values = _numbers(file, rows, head + 1, len(axes))
    place = {
        (body, kind, axis): index
        for index, (body, kind, axis) in enumerate(zip(name, kinds, axes, strict=False))
        if index > 1
    }
    bodies = list(dict.fromkeys(b for b, kind, axis in place if kind == "Rotation" and axis == "W"))
    if not bodies:
        raise LogError(f"{file}: markers and no rigid body; export rigid bodies from Motive")
    scale = _METRES.get(about.get("Length Units", "Meters").lower(), 1.0)
    states = []
    told: tuple[str, ...] = ()
    for body in bodies:
        x, z = (values[:, place[body, "Position", axis]] for axis in "XZ")
        turned = [values[:, place[body, "Rotation", axis]] for axis in "XYZW"]
        # About the y axis, which is up: the same turn with the axes called x, -z, y.
        heading, body_told = headings_of(np.stack([turned[0], -turned[2], turned[1], turned[3]]))
        told += (f"{body}: rotations{body_told}",) if body_told else ()
        states.append(np.stack([x * scale, -z * scale, heading], axis=1))
    notes = (
        f"Motive export: {', '.join(bodies)}; y is up, so the floor is x and -z",
        f"lengths in {about.get('Length Units', 'Meters').lower()}",
        *told,
    )
    poses = np.stack(states, axis=2)
    return Found(values[:, 1], poses, notes, lengths_told=True, angles_told=True)


def _read_vicon(file: Path, options: ReadOptions) -> Found:
    rows = _rows(file, options)
    head = next((i for i, row in enumerate(rows[:8]) if row[:1] == ["Frame"]), None)
    if head is None or head < 2 or len(rows) < head + 3:
        raise LogError(f"{file}: a Vicon export without its line Frame")
    axes, units = rows[head], rows[head + 1]
    rate = _rate(rows[1][0] if rows[1] else "")
    values = _numbers(file, rows, head + 2, len(axes))
    bodies = [(i, cell.rpartition(":")[2]) for i, cell in enumerate(rows[head - 1]) if cell]
    states = []
    told: tuple[str, ...] = ()
    for (first, body), (last, _) in zip(bodies, [*bodies[1:], (len(axes), "")], strict=True):
        place = {axis: first + k for k, axis in enumerate(axes[first:last])}
        if not {"RZ", "TX", "TY"} <= set(place):
            raise LogError(f"{file}: {body} has no RZ, TX and TY; export objects from Vicon")
        length = LENGTHS.get(units[place["TX"]], 1e-3)
        if "RW" in place:
            parts = np.stack([values[:, place[part]] for part in ("RX", "RY", "RZ", "RW")])
            heading, body_told = headings_of(parts)
            told += (f"{body}: rotations{body_told}",) if body_told else ()
        else:
            heading = values[:, place["RZ"]] * ANGLES.get(units[place["RZ"]], 1.0)
        x, y = (values[:, place[axis]] * length for axis in ("TX", "TY"))
        states.append(np.stack([x, y, heading], axis=1))
    if not states or rate is None:
        raise LogError(f"{file}: a Vicon export without objects, or without its frames a second")
    notes = (
        f"Vicon export: {', '.join(name for _, name in bodies)}; {rate:g} frames a second",
        f"lengths in {units[next(i for i, a in enumerate(axes) if a == 'TX')]}",
        *told,
    )
    t = (values[:, 0] - values[0, 0]) / rate
    return Found(t, np.stack(states, axis=2), notes, lengths_told=True, angles_told=True)


def _rate(cell: str) -> float | None:
    try:
        rate = float(cell)
    except ValueError:
        return None
    return rate if 0 < rate < 1e5 else None


MOTIVE = Form(
    name="motive",
    label="Motive CSV",
    summary="rigid bodies of OptiTrack, rotations as quaternions",
    told_by=Sign.CONTENT,
    recognises=lambda file, start: start.removeprefix(b"\xef\xbb\xbf").startswith(
        b"Format Version,"
    ),
    read=_read_motive,
)
VICON = Form(
    name="vicon",
    label="Vicon CSV",
    summary="objects of Vicon Tracker, millimetres",
    told_by=Sign.CONTENT,
    recognises=lambda file, start: (
        start.removeprefix(b"\xef\xbb\xbf").startswith((b"Objects", b"Segments")) and b"TX" in start
    ),
    read=_read_vicon,
)
