"""Files of the UTIAS multi-robot data set (MRCLAM): one a robot and kind.

``Robot1_Groundtruth.dat`` holds a robot's poses, ``Robot1_Odometry.dat`` its commands, which are
three columns as well and would be taken for a pose.
"""

from __future__ import annotations

from pathlib import Path

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.forms import Form, Sign
from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.readers.tables import read_table


def _recognises(file: Path, start: bytes) -> bool:
    comments = [line.lower() for line in start.splitlines() if line.startswith(b"#")]
    return any(b"time [s]" in line for line in comments)


def _read(file: Path, options: ReadOptions) -> Found:
    table = read_table(file, options.bounds)
    with file.open(encoding="utf-8", errors="replace") as stream:
        header = stream.read(1024).lower()
    if "orientation" not in header or table.values.shape[1] != 4:
        raise LogError(
            f"{file}: a file of the MRCLAM data set without poses (odometry or measurements); "
            "expected Robot…_Groundtruth.dat"
        )
    notes = ("MRCLAM ground truth: one robot",)
    poses = table.values[:, 1:, None]
    return Found(table.values[:, 0], poses, notes, lengths_told=True, angles_told=True)


MRCLAM = Form(
    name="mrclam",
    label="MRCLAM",
    summary="`Robot1_Groundtruth.dat`; several with `--join`",
    told_by=Sign.CONTENT,
    recognises=_recognises,
    read=_read,
    endings=(".dat",),
)
