"""A log as MCAP, for Foxglove: JSON messages in Foxglove's own well-known schemas.

The 3D panel shows the robots without any extension.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import OutputError
from posflock_robotarium.logs.run import Run
from rps_compat.testbed import ROBOT_LENGTH, ROBOT_WIDTH
from rps_compat.whole_files import atomic_write

FRAME = "arena"
"""Name of the coordinate frame."""

Json = dict[str, Any]
"""A message or a schema, as it is written."""


def write_mcap(recording: Run, path: Path) -> None:
    """Write poses, a scene of robot bodies, and commands.

    Parameters
    ----------
    recording : Run
        Commands are left out where they are unknown.
    path : Path
        Where the MCAP file goes; one that is there is replaced.

    Raises
    ------
    OutputError
        Where the extra ``mcap`` is not installed, or the file cannot be written.
    """
    try:
        from mcap.writer import Writer
    except ImportError as error:
        raise OutputError(
            "MCAP needs the extra: pip install 'posflock-robotarium[mcap]'"
        ) from error
    with atomic_write(path) as draft, draft.open("wb") as file:
        writer: Any = Writer(file)
        writer.start(profile="", library="posflock")
        channels = {
            topic: writer.register_channel(
                topic=topic,
                message_encoding="json",
                schema_id=writer.register_schema(
                    name=name, encoding="jsonschema", data=json.dumps(schema).encode()
                ),
            )
            for topic, (name, schema) in _CHANNELS.items()
        }
        for k, t in enumerate(recording.t.tolist()):
            nanoseconds = round((t - min(0.0, float(recording.t[0]))) * 1e9)
            stamp = {"sec": nanoseconds // 10**9, "nsec": nanoseconds % 10**9}
            poses = [_pose(*state) for state in recording.poses[k].T.tolist()]
            messages: dict[str, Json] = {
                "/poses": {"timestamp": stamp, "frame_id": FRAME, "poses": poses},
                "/robots": _scene(stamp, poses),
            }
            if recording.commands is not None:
                speed, turn = _told(recording.commands[k])
                messages["/commands"] = {"timestamp": stamp, "v": speed, "omega": turn}
            for topic, message in messages.items():
                writer.add_message(
                    channel_id=channels[topic],
                    log_time=nanoseconds,
                    publish_time=nanoseconds,
                    sequence=k,
                    data=json.dumps(message, separators=(",", ":")).encode(),
                )
        writer.finish()


def _told(commands: NDArray[np.float64]) -> list[list[float | None]]:
    """Return the commands (2, N) for JSON, which has no NaN."""
    return [[None if np.isnan(value) else value for value in row] for row in commands.tolist()]


def _pose(x: float, y: float, heading: float) -> Json:
    """Return a pose; one that is not known has null for its numbers, which JSON has no NaN for."""
    if math.isnan(x):
        return {
            "position": {"x": None, "y": None, "z": 0.0},
            "orientation": {"x": 0.0, "y": 0.0, "z": None, "w": None},
        }
    heading = 0.0 if math.isnan(heading) else heading
    return {
        "position": {"x": x, "y": y, "z": 0.0},
        "orientation": {
            "x": 0.0,
            "y": 0.0,
            "z": float(np.sin(heading / 2)),
            "w": float(np.cos(heading / 2)),
        },
    }


def _scene(stamp: dict[str, int], poses: list[Json]) -> Json:
    """Return one entity a robot that is seen: its body, and an arrow along its heading."""
    size = {"x": ROBOT_LENGTH, "y": ROBOT_WIDTH, "z": 0.06}
    blue = {"r": 0.0, "g": 0.447, "b": 0.698, "a": 1.0}
    white = {"r": 1.0, "g": 1.0, "b": 1.0, "a": 1.0}
    arrow = {
        "shaft_length": 0.05,
        "shaft_diameter": 0.015,
        "head_length": 0.04,
        "head_diameter": 0.04,
    }
    entities = [
        {
            "timestamp": stamp,
            "frame_id": FRAME,
            "id": f"robot {index}",
            "lifetime": {"sec": 0, "nsec": 0},
            "frame_locked": False,
            "metadata": [],
            "arrows": [{"pose": pose, **arrow, "color": white}],
            "cubes": [{"pose": pose, "size": size, "color": blue}],
            "spheres": [],
            "cylinders": [],
            "lines": [],
            "triangles": [],
            "texts": [],
            "models": [],
        }
        for index, pose in enumerate(poses, start=1)
        if pose["position"]["x"] is not None
    ]
    gone = [
        {"timestamp": stamp, "type": 0, "id": f"robot {index}"}
        for index, pose in enumerate(poses, start=1)
        if pose["position"]["x"] is None
    ]
    return {"deletions": gone, "entities": entities}


def _numbers(*names: str) -> Json:
    return {"type": "object", "properties": {name: {"type": "number"} for name in names}}


_TIME = {
    "type": "object",
    "title": "time",
    "properties": {
        "sec": {"type": "integer", "minimum": 0},
        "nsec": {"type": "integer", "minimum": 0, "maximum": 999_999_999},
    },
}
_POSE = {
    "type": "object",
    "title": "foxglove.Pose",
    "properties": {
        "position": {"title": "foxglove.Vector3", **_numbers("x", "y", "z")},
        "orientation": {"title": "foxglove.Quaternion", **_numbers("x", "y", "z", "w")},
    },
}
_COLOUR = {"title": "foxglove.Color", **_numbers("r", "g", "b", "a")}
_ANYTHING = {"type": "array", "items": {"type": "object"}}
_ENTITY = {
    "type": "object",
    "title": "foxglove.SceneEntity",
    "properties": {
        "timestamp": _TIME,
        "frame_id": {"type": "string"},
        "id": {"type": "string"},
        "lifetime": _TIME | {"title": "duration"},
        "frame_locked": {"type": "boolean"},
        "metadata": _ANYTHING,
        "arrows": {
            "type": "array",
            "items": {
                "type": "object",
                "title": "foxglove.ArrowPrimitive",
                "properties": {
                    "pose": _POSE,
                    **{
                        name: {"type": "number"}
                        for name in (
                            "shaft_length",
                            "shaft_diameter",
                            "head_length",
                            "head_diameter",
                        )
                    },
                    "color": _COLOUR,
                },
            },
        },
        "cubes": {
            "type": "array",
            "items": {
                "type": "object",
                "title": "foxglove.CubePrimitive",
                "properties": {
                    "pose": _POSE,
                    "size": {"title": "foxglove.Vector3", **_numbers("x", "y", "z")},
                    "color": _COLOUR,
                },
            },
        },
        **dict.fromkeys(
            ("spheres", "cylinders", "lines", "triangles", "texts", "models"), _ANYTHING
        ),
    },
}
_CHANNELS: dict[str, tuple[str, Json]] = {
    "/poses": (
        "foxglove.PosesInFrame",
        {
            "title": "foxglove.PosesInFrame",
            "type": "object",
            "properties": {
                "timestamp": _TIME,
                "frame_id": {"type": "string"},
                "poses": {"type": "array", "items": _POSE},
            },
        },
    ),
    "/robots": (
        "foxglove.SceneUpdate",
        {
            "title": "foxglove.SceneUpdate",
            "type": "object",
            "properties": {
                "deletions": _ANYTHING,
                "entities": {"type": "array", "items": _ENTITY},
            },
        },
    ),
    "/commands": (
        "posflock.Commands",
        {
            "title": "posflock.Commands",
            "type": "object",
            "description": "Commanded speed (m/s) and turn rate (rad/s) of each robot.",
            "properties": {
                "timestamp": _TIME,
                "v": {"type": "array", "items": {"type": "number"}},
                "omega": {"type": "array", "items": {"type": "number"}},
            },
        },
    ),
}
