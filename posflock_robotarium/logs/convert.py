"""A log in other tools' formats: MATLAB, CSV, NumPy, and MCAP for Foxglove.

What is written as ``.mat``, ``.csv`` or ``.npz`` is read back by `readers.read` as the same
recording, to the last bit, with its parameters; a CSV holds poses and parameters alone. MCAP
carries JSON messages in Foxglove's own well-known schemas, so the 3D panel shows the robots
without any extension.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import OutputError, ParameterError
from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.logs.readers import Run, named_arrays, parameters
from rps_compat.testbed import ROBOT_LENGTH, ROBOT_WIDTH

Floats = NDArray[np.float64]

FRAME = "arena"
"""Name of the coordinate frame in MCAP files."""


def convert(recording: Run, path: Path) -> Path:
    """Write a recording in the format that the path's ending names.

    Parameters
    ----------
    recording : Run
        Poses over time.
    path : Path
        Ends in ``.mat``, ``.csv``, ``.npz`` or ``.mcap``.

    Returns
    -------
    Path
        Where the file was written.

    Raises
    ------
    ParameterError
        For another ending.
    OutputError
        When the file cannot be written, or the extra ``mcap`` is not installed.
    """
    writer = WRITERS.get(path.suffix.lower().lstrip("."))
    if writer is None:
        raise ParameterError(f"{path}: expected an ending among {', '.join(WRITERS)}")
    try:
        writer(recording, path)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror or error})") from error
    return path


def write_pose_log(recording: Run, path: Path) -> Path:
    """Write a run as a pose log, ``NAME.npy`` and ``NAME.json``; return the path of the rows.

    Parameters
    ----------
    recording : Run
        What nobody knows of it is written as unknown.
    path : Path
        With or without ``.npy``.

    Raises
    ------
    OutputError
        Where the files cannot be written.
    """
    own = ("ended", "format", "robots", "units", "versions")
    known = {name: value for name, value in recording.parameters.items() if name not in own}
    samples, _, robots = recording.poses.shape
    unknown = np.full(samples, np.nan)

    def of(column: NDArray[Any] | None, otherwise: NDArray[Any] = unknown) -> NDArray[Any]:
        return otherwise if column is None else column

    commands = of(recording.commands, np.full((samples, 2, robots), np.nan))
    status = of(recording.status, np.full(samples, ""))
    intervention, clearance = of(recording.intervention), of(recording.clearance)
    log = PoseLog(path, robots, samples, known)
    for k, t in enumerate(recording.t.tolist()):
        log.append(
            t,
            recording.poses[k],
            commands[k],
            status=str(status[k]),
            intervention=float(intervention[k]),
            clearance=float(clearance[k]),
        )
    ending = recording.ending
    log.close(*(("finished", "") if ending is None else (ending.how.value, ending.reason)))
    return log.path


def _write_pose_log(recording: Run, path: Path) -> None:
    write_pose_log(recording, path)


def _write_mat(recording: Run, path: Path) -> None:
    """Write t (T, 1) and poses (3, N, T), the shape of MATLAB scripts on the testbed."""
    from scipy.io import savemat

    variables: dict[str, Any] = {
        "t": recording.t[:, np.newaxis],
        "poses": recording.poses.transpose(1, 2, 0),
        **_description(recording),
    }
    for name in ("intervention", "clearance"):
        if name in variables:
            variables[name] = variables[name][:, np.newaxis]
    if "status" in variables:  # char(status) in MATLAB; the reader takes numbers alone
        variables["status"] = named_arrays.codes_of(variables["status"])
    if recording.commands is not None:
        variables["command"] = recording.commands.transpose(1, 2, 0)
    savemat(path, variables, do_compression=True)


def _write_csv(recording: Run, path: Path) -> None:
    """Write the parameters as a comment, then one row a sample: t, x1, y1, theta1, x2 and so on."""
    names = [
        f"{state}{robot + 1}" for robot in range(recording.robots) for state in ("x", "y", "theta")
    ]
    flat = recording.poses.transpose(0, 2, 1).reshape(len(recording.t), -1)
    with path.open("w", newline="", encoding="utf-8") as file:
        if recording.parameters:
            file.write(f"# {parameters.NAME}: {parameters.to_json(recording.parameters)}\n")
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["t", *names])
        table.writerows(map(repr, row) for row in np.column_stack([recording.t, flat]).tolist())


def _write_npz(recording: Run, path: Path) -> None:
    """Write t (T,), poses (T, 3, N) and whatever else is known, command (T, 2, N) first."""
    arrays: dict[str, NDArray[Any]] = {
        "t": recording.t,
        "poses": recording.poses,
        **_description(recording),
    }
    if recording.commands is not None:
        arrays["command"] = recording.commands
    with path.open("wb") as file:
        np.savez_compressed(file, **arrays)  # type: ignore[arg-type]


def _description(recording: Run) -> dict[str, NDArray[Any]]:
    """Return the parameters, and what the certificate did at each step, where they are known."""
    known = {name: getattr(recording, name) for name in ("intervention", "clearance", "status")}
    if recording.parameters:
        known[parameters.NAME] = parameters.to_bytes(recording.parameters)
    return {name: values for name, values in known.items() if values is not None}


def _write_mcap(recording: Run, path: Path) -> None:
    """Write poses, a scene of robot bodies, and commands as Foxglove's JSON messages."""
    try:
        from mcap.writer import Writer
    except ImportError as error:
        raise OutputError(
            "MCAP needs the extra: pip install 'posflock-robotarium[mcap]'"
        ) from error
    with path.open("wb") as file:
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
            messages: dict[str, dict[str, Any]] = {
                "/poses": {"timestamp": stamp, "frame_id": FRAME, "poses": poses},
                "/robots": _scene(stamp, poses),
            }
            if recording.commands is not None:
                speed, turn = recording.commands[k].tolist()
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


def _pose(x: float, y: float, heading: float) -> dict[str, dict[str, float]]:
    return {
        "position": {"x": x, "y": y, "z": 0.0},
        "orientation": {
            "x": 0.0,
            "y": 0.0,
            "z": float(np.sin(heading / 2)),
            "w": float(np.cos(heading / 2)),
        },
    }


def _scene(stamp: dict[str, int], poses: list[dict[str, dict[str, float]]]) -> dict[str, Any]:
    """Return one entity a robot: its body, and an arrow along its heading."""
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
    ]
    return {"deletions": [], "entities": entities}


def _numbers(*names: str) -> dict[str, Any]:
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
_CHANNELS: dict[str, tuple[str, dict[str, Any]]] = {
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

WRITERS: dict[str, Callable[[Run, Path], None]] = {
    "npy": _write_pose_log,
    "mat": _write_mat,
    "csv": _write_csv,
    "npz": _write_npz,
    "mcap": _write_mcap,
}
"""Writer by ending."""
