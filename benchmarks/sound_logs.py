"""Sound logs of every form that the readers know, for benchmarks that damage them.

Text forms are cells and a separator (`Sheet`), so that cells can be changed before writing.
"""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
EPOCH = 1_700_000_000
ODOMETRY, STAMPED = "nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseStamped"


@dataclass(frozen=True)
class Sheet:
    """The lines of a text file as cells, and what stands between them."""

    ending: str
    lines: list[list[str]]
    mark: str = ","

    def text(self, end: str = "\n") -> str:
        """Return what the file holds."""
        return "".join(self.mark.join(line) + end for line in self.lines)


def short_run(samples: int = 40) -> tuple[Floats, Floats]:
    """Return times and poses of three robots that drive in circles."""
    t = 0.1 * np.arange(samples)
    phases = np.array([0.0, 2.0, 4.0])
    angle = 0.3 * t[:, np.newaxis] + phases
    return t, np.stack([0.5 * np.cos(angle), 0.5 * np.sin(angle), angle + np.pi / 2], axis=1)


def _cells(columns: list[Any]) -> list[list[str]]:
    lists = [np.asarray(column).tolist() for column in columns]
    return [[repr(value) for value in row] for row in zip(*lists, strict=True)]


def tum() -> Sheet:
    t, poses = short_run()
    (x, y, theta), zero = poses[:, :, 0].T, np.zeros(len(t))
    turned = [zero, zero, np.sin(theta / 2), np.cos(theta / 2)]
    return Sheet(".txt", _cells([EPOCH + t, x, y, zero, *turned]), " ")


def euroc() -> Sheet:
    t, poses = short_run()
    (x, y, theta), zero = poses[:, :, 0].T, np.zeros(len(t))
    head = ["#timestamp", *(f"p_RS_R_{a} [m]" for a in "xyz"), *(f"q_RS_{a} []" for a in "wxyz")]
    turned = [np.cos(theta / 2), zero, zero, np.sin(theta / 2)]
    return Sheet(".csv", [head, *_cells([_ns(t), x, y, zero, *turned])])


def ros_csv() -> Sheet:
    t, poses = short_run()
    (x, y, theta), zero = poses[:, :, 0].T, np.zeros(len(t))
    pose = "field.pose.pose"
    head = ["%time", "field.header.stamp", *(f"{pose}.position.{a}" for a in "xyz")]
    head += [f"{pose}.orientation.{a}" for a in "xyzw"]
    turned = [zero, zero, np.sin(theta / 2), np.cos(theta / 2)]
    return Sheet(".csv", [head, *_cells([_ns(t), _ns(t), x, y, zero, *turned])])


def mrclam() -> Sheet:
    t, poses = short_run()
    head = [["# Robot 1"], ["# Time [s]    x [m]    y [m]    orientation [rad]"]]
    return Sheet(".dat", [*head, *_cells([EPOCH + t, *poses[:, :, 0].T])], "\t")


def motive() -> Sheet:
    t, poses = short_run()
    robots, zero = poses.shape[2], np.zeros(len(t))
    head = [
        ["Format Version", "1.23", "Take Name", "run", "Rotation Type", "Quaternion",
         "Length Units", "Millimeters"],
        [""],
        ["", "", *["Rigid Body"] * (7 * robots)],
        ["", "Name", *(f"r{n}" for n in range(robots) for _ in range(7))],
        ["", "ID", *["1"] * (7 * robots)],
        ["", "", *(["Rotation"] * 4 + ["Position"] * 3) * robots],
        ["Frame", "Time (Seconds)", *"XYZWXYZ" * robots],
    ]  # fmt: skip
    columns = [np.arange(len(t)), t]
    for x, y, theta in poses.transpose(2, 1, 0):
        columns += [zero, np.sin(theta / 2), zero, np.cos(theta / 2), 1e3 * x, zero, -1e3 * y]
    return Sheet(".csv", [*head, *_cells(columns)])


def vicon() -> Sheet:
    t, poses = short_run()
    robots, zero = poses.shape[2], np.zeros(len(t))
    head = [
        ["Objects"],
        ["10.0"],
        ["", "", *(cell for n in range(robots) for cell in (f"lab:r{n}", "", "", "", "", ""))],
        ["Frame", "Sub Frame", *["RX", "RY", "RZ", "TX", "TY", "TZ"] * robots],
        ["", "", *["rad", "rad", "rad", "mm", "mm", "mm"] * robots],
    ]
    columns = [1 + np.arange(len(t)), np.zeros(len(t), int)]
    for x, y, theta in poses.transpose(2, 1, 0):
        columns += [zero, zero, theta, 1e3 * x, 1e3 * y, zero]
    return Sheet(".csv", [*head, *_cells(columns)])


def with_units() -> Sheet:
    t, poses = short_run()
    head = ["time_ms", *(f"{s}{n}" for n in range(3) for s in ("x", "y", "theta"))]
    head = [word + {"x": " [mm]", "y": "_mm", "t": ""}.get(word[0], "") for word in head]
    head = [word + ("_deg" if word.startswith("theta") else "") for word in head]
    columns = [1e3 * t]
    for x, y, theta in poses.transpose(2, 1, 0):
        columns += [1e3 * x, 1e3 * y, np.degrees(theta)]
    return Sheet(".csv", [head, *_cells(columns)])


SHEETS: tuple[Callable[[], Sheet], ...] = (
    tum, euroc, ros_csv, mrclam, motive, vicon, with_units,
)  # fmt: skip


def _ns(t: Floats) -> NDArray[np.int64]:
    return EPOCH * 10**9 + np.round(1e9 * t).astype(np.int64)


def bag(folder: Path, sqlite: bool, kind: str = STAMPED, samples: int = 20) -> Path:
    """Write a ROS 2 bag with three topics, and return its one file of messages."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    t, poses = short_run(samples)
    store = get_typestore(Stores.LATEST)
    plugin = StoragePlugin.SQLITE3 if sqlite else StoragePlugin.MCAP
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        for n in range(poses.shape[2]):
            topic = writer.add_connection(f"/r{n}/pose", kind, typestore=store)
            for k, seconds in enumerate((EPOCH + t + 0.004 * n).tolist()):
                message = _message(store.types, kind, seconds, *poses[k, :, n].tolist())
                writer.write(topic, round(seconds * 1e9), store.serialize_cdr(message, kind))
    return next(path for path in folder.iterdir() if path.suffix in (".db3", ".mcap"))


def _message(of: Any, kind: str, t: float, x: float, y: float, theta: float) -> Any:
    place = of["geometry_msgs/msg/Point"](x, y, 0.0)
    turned = of["geometry_msgs/msg/Quaternion"](0.0, 0.0, np.sin(theta / 2), np.cos(theta / 2))
    stamp = of["builtin_interfaces/msg/Time"](int(t), round((t - int(t)) * 1e9))
    header = of["std_msgs/msg/Header"](stamp, "arena")
    pose = of["geometry_msgs/msg/Pose"](place, turned)
    if kind == STAMPED:
        return of[kind](header, pose)
    covariance, zero = np.zeros(36), of["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
    with_covariance = of["geometry_msgs/msg/PoseWithCovariance"](pose, covariance)
    twist = of["geometry_msgs/msg/Twist"](zero, zero)
    moved = of["geometry_msgs/msg/TwistWithCovariance"](twist, covariance)
    return of[kind](header, "robot", with_covariance, moved)


def write_trackers(folder: Path) -> None:
    """Write a sound file of each form of trackers, middleware and archives."""
    from posflock_robotarium.logs.convert import convert
    from posflock_robotarium.report import Run

    for make in SHEETS:
        sheet = make()
        (folder / f"{make.__name__}{sheet.ending}").write_text(sheet.text())
    t, poses = short_run()
    convert(Run("run", t, poses, commands=np.full((len(t), 2, 3), 0.1)), folder / "own.mcap")
    for sqlite in (True, False):
        made = bag(folder / "bag", sqlite)
        made.rename(folder / f"bag{made.suffix}")
        for rest in (folder / "bag").iterdir():
            rest.unlink()
        (folder / "bag").rmdir()
    with zipfile.ZipFile(folder / "folder.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for n in range(3):
            rows = np.column_stack([t, poses[:, :, n]])
            lines = [["t", "x", "y", "theta"], *_cells(list(rows.T))]
            archive.writestr(f"robot{n}.csv", Sheet(".csv", lines).text())
