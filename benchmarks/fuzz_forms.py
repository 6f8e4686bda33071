"""Makers of files that are sound as files and wrong in what they say: trackers, bags, MCAP, zips.

Each takes a generator of random numbers and a folder, writes one file and returns its path; see
`fuzz_structures`, which reads them.
"""

from __future__ import annotations

import json
import sqlite3
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from sound_logs import ODOMETRY, SHEETS, STAMPED, Sheet, bag, short_run

Rng = np.random.Generator

ABSURD = (0, -1, 1, 2**31, 2**63, 10**40, 1e308, -1e308, float("nan"), float("inf"), "", "x", None,
          True, [], {}, [[]], "\x1b[2J", "../../etc/passwd", "é" * 300)  # fmt: skip
NO_CELLS = ("1e308", "nan", "", '"', "1_0", "0x10", "1e999", "٣", "\0", "-1", "0", "9" * 400)


def pick(rng: Rng, options: Any) -> Any:
    """Return one of some options, as it is."""
    return options[int(rng.integers(0, len(options)))]


def spoil(rng: Rng, lines: list[list[str]], least: int = 0) -> None:
    """Change some cells and lines of a table: doubled, missing, or not what they should be."""
    for _ in range(int(rng.integers(least, 4))):
        line = lines[int(rng.integers(0, len(lines)))]
        at = int(rng.integers(0, len(line))) if line else 0
        change = int(rng.integers(0, 5))
        if change == 0 and line:
            del line[at]
        elif change == 1:
            line.insert(at, pick(rng, NO_CELLS))
        elif change == 2 and line:
            line[at] = pick(rng, ("t", "inf", "-", "1,5", "#", "'", '"1"', "9" * 5000, *NO_CELLS))
        elif change == 3:
            lines.insert(int(rng.integers(0, len(lines))), list(line))
        else:
            lines.append([])


def sheet(rng: Rng, work: Path) -> Path:
    """Write what a tracker exports, or a table with units, with cells that it would not have."""
    made: Sheet = pick(rng, SHEETS)()
    head = min(8, len(made.lines))
    spoilt = made.lines[:head] if rng.random() < 0.7 else made.lines
    spoil(rng, spoilt, least=1)
    lines = spoilt + made.lines[head:] if spoilt is not made.lines else spoilt
    if rng.random() < 0.2:
        lines = lines[: int(rng.integers(0, len(lines)))]
    path = work / f"file{made.ending}"
    text = Sheet(made.ending, lines, made.mark).text(pick(rng, ("\n", "\r\n", "\r")))
    path.write_bytes(text.encode(pick(rng, ("utf-8", "utf-8-sig", "utf-8", "utf-16")), "replace"))
    return path


def mcap(rng: Rng, work: Path) -> Path:
    """Write MCAP whose channels hold JSON of other shapes, other encodings or absurd times."""
    from mcap.writer import CompressionType, Writer

    path = work / "file.mcap"
    t, poses = short_run(6)
    packing = pick(rng, (CompressionType.NONE, CompressionType.ZSTD, CompressionType.LZ4))
    with path.open("wb") as stream:
        writer = Writer(stream, compression=packing, chunk_size=int(pick(rng, (64, 1 << 20))))
        writer.start(profile=pick(rng, ("", "", "posflock", "ros1", "x" * 300)))
        schema = writer.register_schema("any", pick(rng, ("jsonschema", "", "x")), b"{}")
        for topic in ("/poses", "/commands", "/robots")[: int(rng.integers(1, 4))]:
            channel = writer.register_channel(
                topic, pick(rng, ("json", "json", "json", "cdr")), schema
            )
            for k in range(len(t)):
                data = _message(rng, topic, poses[k])
                log_time = int(pick(rng, (0, 10**8 * k, 10**8 * k, 10**8 * k, 2**63, 2**64 - 1)))
                writer.add_message(channel, log_time, data, log_time, sequence=k)
        writer.finish()
    return path


def _message(rng: Rng, topic: str, states: np.ndarray[Any, Any]) -> bytes:
    """Return one message as posflock writes it, or with a part that is something else."""
    message: dict[str, Any] = {"v": [0.1] * 3, "omega": [0.0] * 3}
    if topic == "/poses":
        message = {
            "poses": [
                {
                    "position": {"x": x, "y": y, "z": 0.0},
                    "orientation": {"x": 0.0, "y": 0.0, "z": np.sin(a / 2), "w": np.cos(a / 2)},
                }
                for x, y, a in states.T.tolist()
            ]
        }
    if rng.random() < 0.3:
        place: Any = message
        for _ in range(int(rng.integers(1, 5))):
            key = pick(rng, [*place] if isinstance(place, dict) else range(len(place)))
            if not isinstance(place[key], (dict, list)) or not place[key] or rng.random() < 0.3:
                break
            place = place[key]
            key = pick(rng, [*place] if isinstance(place, dict) else range(len(place)))
        if rng.random() < 0.3:
            del place[key]
        else:
            place[key] = pick(rng, ABSURD)
    data = json.dumps(message).encode()
    return pick(rng, (b"", b"[", b"[" * 100_000, b"\xff", data)) if rng.random() < 0.05 else data


def ros_bag(rng: Rng, work: Path) -> Path:
    """Write a ROS 2 bag, and change what its tables or its messages say."""
    sqlite = bool(rng.random() < 0.7)
    made = bag(work / "bag", sqlite, pick(rng, (STAMPED, ODOMETRY)), samples=6)
    path = work / f"file{made.suffix}"
    made.rename(path)
    if sqlite:
        with sqlite3.connect(path) as base:
            for _ in range(int(rng.integers(1, 3))):
                _change_table(rng, base)
        base.close()
    elif rng.random() < 0.7:  # of the same length, so that all offsets stay
        kinds = (
            (b"PoseStamped", b"XoseStamped"),
            (b"Point", b"Paint"),
            (b"/r1", b"/r2"),
            (b"cdr", b"xyz"),
        )
        path.write_bytes(path.read_bytes().replace(*pick(rng, kinds)))
    if rng.random() < 0.3:  # a bag is a folder: its description may say something else
        description = work / "bag" / "metadata.yaml"
        text = description.read_text()
        description.write_text(pick(rng, ("", "x", text.replace("9", "x"), text[: len(text) // 2])))
        path.rename(made)
        path = (work / "bag").rename(work / "file")
    return path


def _change_table(rng: Rng, base: sqlite3.Connection) -> None:
    """Change one thing in the tables of a bag."""
    absurd = pick(rng, (None, -1, 2**62, "x", b"", b"\0" * 4, b"\xff" * 90, 1e308, "x" * 10_000))
    table, column = pick(
        rng,
        (("topics", "name"), ("topics", "type"), ("topics", "serialization_format"),
         ("topics", "offered_qos_profiles"), ("topics", "id"), ("messages", "topic_id"),
         ("messages", "timestamp"), ("messages", "data")),
    )  # fmt: skip
    where = pick(rng, ("", " WHERE id = 2", " WHERE id % 3 = 0"))
    change = pick(rng, ("set", "set", "set", "drop", "rename", "empty"))
    try:
        if change == "set":
            base.execute(f"UPDATE {table} SET {column} = ?{where}", (absurd,))
        elif change == "drop":
            base.execute(f"DROP TABLE {table}")
        elif change == "rename":
            base.execute(f"ALTER TABLE {table} RENAME COLUMN {column} TO other")
        else:
            base.execute(f"DELETE FROM {table}{where}")
    except sqlite3.Error:
        return  # that such a table does not allow


def zipped(rng: Rng, work: Path) -> Path:
    """Write a ``.zip`` with logs of several forms, under names and with sizes that are none."""
    path = work / "file.zip"
    with zipfile.ZipFile(path, "w", pick(rng, (0, 8, 12, 14))) as archive:
        for k in range(int(rng.integers(0, 5))):
            made: Sheet = pick(rng, SHEETS)()
            spoil(rng, made.lines)
            plain = f"robot{k}{made.ending}"
            strange = ("../x.csv", "/etc/x.csv", "C:\\x.csv", "a/robot0.csv", "x\x1b.csv", "x.npy",
                       "__MACOSX/x.csv", "é" * 120 + ".csv", "CON.csv", "x.csv/")  # fmt: skip
            name = plain if rng.random() < 0.6 else pick(rng, strange)
            archive.writestr(name, made.text().encode(errors="replace"))
        if rng.random() < 0.1:
            for k in range(300):
                archive.writestr(f"many{k}.csv", b"t,x,y,theta\n0,0,0,0\n1,0,0,0\n")
    if rng.random() < 0.2:  # the first member claims another size, in both of its headers
        content = bytearray(path.read_bytes())
        size = int(pick(rng, (0, 1, 300 << 20, 2**32 - 1))).to_bytes(4, "little")
        for mark, offset in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):
            at = content.find(mark) + offset
            if at >= offset:
                content[at : at + 4] = size
        path.write_bytes(content)
    return path
