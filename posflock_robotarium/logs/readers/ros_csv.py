"""Odometry and poses of ROS as CSV: what ``rostopic echo -p`` and similar exporters write.

The header spells out the message: ``field.pose.pose.position.x`` and so on. Times are nanoseconds:
the message's own stamp where it goes on from row to row, else when it was recorded.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.forms import Form, Sign
from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.readers.quaternions import headings_of
from posflock_robotarium.logs.readers.tables import read_table

Floats = NDArray[np.float64]

_QUATERNION = ("x", "y", "z", "w")
_GOES_ON = 0.8
"""Share of rows in which a stamp is a new one, from which on it is the time of the pose."""


def _is_ros_csv(file: Path, start: bytes) -> bool:
    head = start.splitlines()[0] if start else b""
    head = head.replace(b"/", b".")
    turned = b"orientation.x" in head or b"orientation.yaw" in head
    return b"position.x" in head and turned and b"," in head


def _read(file: Path, options: ReadOptions) -> Found:
    table = read_table(file, options.bounds)
    with file.open(encoding="utf-8-sig", errors="replace") as stream:
        # PlotJuggler writes /odom/pose/pose/position/x, and __time in seconds.
        head = [cell.strip().lstrip("%").replace("/", ".") for cell in next(csv.reader(stream))]
    names = [name.removesuffix(".") for name in head]
    if len(names) != table.values.shape[1]:
        raise LogError(
            f"{file}: the header names {len(names)} columns, the rows have {table.values.shape[1]}"
        )

    def column(ending: str) -> Floats:
        index = next((i for i, name in enumerate(names) if name.endswith(ending)), None)
        if index is None:
            raise LogError(f"{file}: no column ends in {ending}; expected a pose")
        return table.values[:, index]

    t, clock = _time(names, table.values)
    if any(name.endswith("orientation.yaw") for name in names):
        heading, told = column("orientation.yaw"), "; its yaw is there"
    else:
        parts = [column(f"orientation.{part}") for part in _QUATERNION]
        heading, told = headings_of(np.stack(parts))
    poses = np.stack([column("position.x"), column("position.y"), heading], axis=1)
    notes = ["ROS messages as CSV: one robot, heading from its orientation" + told, *table.notes]
    if t is not None:
        notes.append(f"times from {clock}")
    return Found(t, poses[:, :, np.newaxis], tuple(notes), lengths_told=True, angles_told=True)


def _time(names: list[str], values: Floats) -> tuple[Floats | None, str]:
    """Return seconds, and the column that they are from."""
    clocks: list[tuple[Floats, str]] = []
    places = {name: index for index, name in enumerate(names)}
    for name, index in places.items():
        if name.endswith("stamp"):
            clocks.append((values[:, index] * 1e-9, name))
        elif name.endswith(("stamp.sec", "stamp.secs")):
            rest = next(
                (i for n, i in places.items() if "stamp.nano" in n or "stamp.nsec" in n), None
            )
            fraction = 0.0 if rest is None else values[:, rest] * 1e-9
            clocks.append((values[:, index] + fraction, name))
    if "time" in places:
        clocks.append((values[:, places["time"]] * 1e-9, "time"))
    if "__time" in places:
        clocks.append((values[:, places["__time"]], "__time"))
    for t, name in clocks:
        if len(t) > 1 and np.mean(np.diff(t) > 0) >= _GOES_ON:
            return t, name
    return clocks[-1] if clocks else (None, "")


ROS_CSV = Form(
    name="ros csv",
    label="ROS CSV",
    summary="odometry or poses of one robot as `rostopic echo -p` and PlotJuggler write them",
    told_by=Sign.CONTENT,
    recognises=_is_ros_csv,
    read=_read,
)
