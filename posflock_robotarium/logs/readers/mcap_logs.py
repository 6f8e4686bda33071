"""MCAP files of our own, as ``posflock convert --to mcap`` writes them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.forms import Form, Sign
from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.readers.quaternions import yaw

SIGNATURE = b"\x89MCAP0\r\n"
_POSES, _COMMANDS = "/poses", "/commands"


def _read(file: Path, options: ReadOptions) -> Found:
    try:
        from mcap.reader import make_reader
    except ImportError as error:
        raise LogError(
            f"{file}: reading MCAP needs the extra: pip install 'posflock-robotarium[mcap]'"
        ) from error
    options.bounds.require_size(8 * file.stat().st_size, str(file))
    rows: dict[str, list[tuple[int, dict[str, Any]]]] = {_POSES: [], _COMMANDS: []}
    topics: set[str] = set()
    with file.open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages():
            topics.add(channel.topic)
            if channel.topic in rows and channel.message_encoding == "json":
                rows[channel.topic].append((message.log_time, json.loads(message.data)))
    if not rows[_POSES]:
        raise LogError(
            f"{file}: no {_POSES} as posflock writes them; its topics are "
            f"{', '.join(sorted(topics)[:12]) or 'none'}. Export the robots' poses as CSV, one "
            "file a robot, and report them with --join"
        )
    t = np.array([time for time, _ in rows[_POSES]]) * 1e-9
    poses = np.stack([_states(message["poses"]) for _, message in rows[_POSES]])
    commands = None
    if len(rows[_COMMANDS]) == len(t):
        commands = np.array([[m["v"], m["omega"]] for _, m in rows[_COMMANDS]], dtype=float)
    notes = ("MCAP of posflock, heading from the quaternion",)
    return Found(t, poses, notes, commands, lengths_told=True, angles_told=True)


def _states(poses: list[dict[str, Any]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return x, y and heading of each robot, (3, N)."""
    place = np.array([[p["position"][axis] for axis in "xy"] for p in poses], dtype=float)
    turned = np.array([[p["orientation"][part] for part in "xyzw"] for p in poses], dtype=float)
    return np.vstack([place.T, yaw(*turned.T)])


MCAP = Form(
    name="mcap",
    label="`.mcap`",
    summary="our own (extra `mcap`)",
    told_by=Sign.SIGNATURE,
    recognises=lambda file, start: start.startswith(SIGNATURE),
    read=_read,
    endings=(".mcap",),
)
