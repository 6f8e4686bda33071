"""ROS 2 bags, ``.db3`` and ``.mcap``: each topic with poses is one robot on a clock of its own.

They are read with rosbags, which needs no ROS. Times are the messages' own stamps, or when they
were recorded, where they have none.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.clocks import Track, joined
from posflock_robotarium.logs.readers.forms import Form, Sign
from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.readers.mcap_logs import SIGNATURE
from posflock_robotarium.logs.readers.quaternions import headings_of
from posflock_robotarium.logs.run import LayoutError

_WAYS = {
    "nav_msgs/msg/Odometry": ("pose", "pose"),
    "geometry_msgs/msg/PoseStamped": ("pose",),
    "geometry_msgs/msg/PoseWithCovarianceStamped": ("pose", "pose"),
    "geometry_msgs/msg/Pose": (),
}
"""Messages with a pose, and the way to it."""


def _recognises(file: Path, start: bytes) -> bool:
    if start.startswith(b"SQLite format 3\0"):
        return file.suffix == ".db3"
    return start.startswith(SIGNATURE) and b"ros2" in start[:40]


def _read(file: Path, options: ReadOptions) -> Found:
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise LogError(
            f"{file}: reading ROS 2 bags needs the extra: pip install 'posflock-robotarium[ros]'"
        ) from error
    options.bounds.require_size(4 * file.stat().st_size, str(file))
    rows: dict[str, list[tuple[float, ...]]] = {}
    store = get_typestore(Stores.LATEST)
    with AnyReader([file], default_typestore=store) as bag:
        chosen = _connections(bag.connections, str(file), options)
        for connection, recorded, raw in bag.messages(connections=chosen):
            message = bag.deserialize(raw, connection.msgtype)
            rows.setdefault(connection.topic, []).append(
                _row(message, recorded, _WAYS[connection.msgtype])
            )
    kind = chosen[0].msgtype
    notes = [f"ROS 2 bag, {kind}: a robot a topic, heading from the quaternion"]
    tracks = []
    for topic in sorted(rows):
        t, x, y, *turned = np.array(rows[topic], dtype=float).T
        heading, told = headings_of(np.array(turned))
        if told:
            notes.append(f"{topic}: rotations{told}")
        tracks.append(Track(topic, t, np.stack([x, y, heading], axis=1)))
    if not tracks:
        raise LogError(f"{file}: topics of {kind}, and no message in them")
    if len(tracks) == 1:
        notes.append(f"topic {tracks[0].name}")
        found = Found(tracks[0].t, tracks[0].states[:, :, np.newaxis], ())
    else:
        found = joined(tracks, str(file), notes)
    return Found(found.t, found.poses, tuple(notes), lengths_told=True, angles_told=True)


def _connections(connections: list[Any], where: str, options: ReadOptions) -> list[Any]:
    """Return the topics that hold poses: all of one kind, or the one that the user names."""
    posed = [c for c in connections if c.msgtype in _WAYS]
    if options.array is not None:
        posed = [c for c in posed if options.array in (c.topic, c.msgtype)]
    if not posed:
        topics = ", ".join(f"{c.topic} ({c.msgtype})" for c in connections[:12]) or "none"
        raise LogError(f"{where}: no topic with poses; expected {', '.join(_WAYS)}, got {topics}")
    if len({c.msgtype for c in posed}) > 1:
        topics = ", ".join(f"{c.topic} ({c.msgtype})" for c in posed[:12])
        raise LayoutError(
            f"{where}: poses of several kinds: {topics}; name a topic or a kind with --array"
        )
    return posed


def _row(message: Any, recorded: int, way: tuple[str, ...]) -> tuple[float, ...]:
    """Return seconds, x, y and the quaternion of one message."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    t = recorded * 1e-9 if stamp is None else stamp.sec + stamp.nanosec * 1e-9
    pose = message
    for name in way:
        pose = getattr(pose, name)
    turned = pose.orientation
    place = pose.position
    return (t or recorded * 1e-9, place.x, place.y, turned.x, turned.y, turned.z, turned.w)


ROS_BAG = Form(
    name="ros bag",
    label="ROS 2 bag",
    summary="`.db3` and `.mcap`: odometry or poses, a topic a robot (extra `ros`)",
    told_by=Sign.CONTENT,
    recognises=_recognises,
    read=_read,
    endings=(".db3",),
)
