"""A disk that fills up at every write of every command: an error with a name, nothing lost.

Each command writes into a small file system of its own (a tmpfs in a mount namespace, so that no
rights are needed), first with room enough, then again and again with a little more room each time,
from none to almost enough. Whatever it stops at, it must

- end with exit code 1 or 2 and one line that names a file or the folder, without a traceback;
- leave under final names the earlier results as they were, or new ones that are whole;
- leave no draft behind, and every finished row of a log or a store.

    python benchmarks/faults_full_disk.py [--steps N] [--only COMMAND]
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

STEPS = 12
"""Sizes of free space that are tried for each command."""

DISK = 64 << 20
PAGE = 4096
MOST_SECONDS = 600
"""After which a command counts as one that does not end, on a machine with other work."""

SCRIPT = """
import numpy as np
from rps.robotarium import Robotarium
r = Robotarium(number_of_robots=3)
for _ in range(400):
    r.get_poses()
    r.set_velocities(np.arange(3), np.zeros((2, 3)))
    r.step()
r.call_at_scripts_end() if hasattr(r, "call_at_scripts_end") else r.debug()
"""
STUDY = """
experiment = "freespace"
replications = 40
[parameters]
agents = 4
side = 4.0
duration = 1.0
[grid]
persistence = [0.1, 0.2]
"""


@dataclass(frozen=True)
class Command:
    """A command that writes, and what its results must be whenever they are there.

    Attributes
    ----------
    name : str
        What it is called in the table.
    words : list of str
        What follows ``posflock``; OUT stands for the folder on the small disk.
    replaces : bool
        Whether an earlier result stays until the new one is whole; a run begins anew.
    """

    name: str
    words: list[str]
    replaces: bool = True


def commands(work: Path) -> list[Command]:
    """Write the inputs and return every command that writes."""
    from posflock_robotarium.alignment.truth import known_flock
    from posflock_robotarium.flocking.pose_log import PoseLog

    run = known_flock("rotating", 0.1, robots=4, duration=6.0).recording
    with PoseLog(work / "log", 4, len(run.t), {"neighbour_radius": 0.75}) as log:
        for t, pose in zip(run.t, run.poses, strict=True):
            log.append(t, pose, np.zeros((2, 4)))
    (work / "script.py").write_text(SCRIPT)
    (work / "study.toml").write_text(STUDY)
    (work / "old.py").write_text(SCRIPT)
    log_, script = str(work / "log.npy"), str(work / "script.py")
    convert = [
        Command(f"convert {kind}", ["convert", log_, "--to", kind, "-o", f"OUT/log.{kind}"])
        for kind in ("csv", "npz", "mat", "mcap")
    ]
    return [
        Command("report", ["report", log_, "-o", "OUT", "--latex"]),
        *convert,
        Command("replay gif", ["replay", log_, "--video", "OUT/run.gif", "--speed", "8"]),
        Command("replay mp4", ["replay", log_, "--video", "OUT/run.mp4", "--speed", "8"]),
        Command("bundle", ["bundle", script, "-o", "OUT/up", "--no-run"]),
        Command("verify", ["verify", script, "-o", "OUT", "--trials", "1"], replaces=False),
        Command("run", ["run", "-o", "OUT", script], replaces=False),
        Command("sweep", ["sweep", str(work / "study.toml"), "-o", "OUT"], replaces=False),
    ]


def posflock(words: list[str], out: Path, work: Path) -> subprocess.CompletedProcess[str]:
    """Run a command whose results go onto the small disk."""
    command = [w.replace("OUT", str(out)) for w in words]
    try:
        return subprocess.run(
            [sys.executable, "-m", "posflock_robotarium", *command],
            capture_output=True,
            text=True,
            errors="replace",
            cwd=work,
            timeout=MOST_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        told = f"goes on after {MOST_SECONDS} s"
        return subprocess.CompletedProcess(command, -signal.SIGALRM, "", told)


def contents(folder: Path) -> dict[str, bytes]:
    """Return all files of a folder by their names."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def is_whole(path: Path) -> bool:
    """Tell whether a file is whole, by what its kind ends with or can be opened as."""
    check = _CHECKS.get(path.suffix, lambda file: True)
    try:
        return bool(check(path))
    except Exception:
        return False


def _is_picture(path: Path) -> bool:
    from PIL import Image

    with Image.open(path) as picture:
        for frame in range(getattr(picture, "n_frames", 1)):
            picture.seek(frame)
            picture.load()
    return True


def _is_readable(path: Path) -> bool:
    from posflock_robotarium.logs.readers import LayoutError, read

    try:
        return not read(path).doubts
    except LayoutError:  # such as a CSV of metrics, which is no log
        return path.read_bytes().endswith(b"\n")


def _is_archive(path: Path) -> bool:
    with np.load(path, allow_pickle=False) as arrays:
        return all(arrays[name] is not None for name in arrays)


def _ends_with(end: bytes) -> Callable[[Path], bool]:
    return lambda path: path.read_bytes().rstrip().endswith(end)


def _is_parquet(path: Path) -> bool:
    from pyarrow import parquet

    return parquet.read_table(path).num_rows >= 0


_CHECKS: dict[str, Callable[[Path], bool]] = {
    ".html": _ends_with(b"</html>"),
    ".json": lambda path: json.loads(path.read_text()) is not None,
    ".npz": _is_archive,
    ".csv": lambda path: path.read_bytes().endswith(b"\n") or not path.stat().st_size,
    ".mat": _is_readable,
    ".npy": lambda path: np.load(path).shape is not None,
    ".mcap": _ends_with(b"\x89MCAP0\r\n"),
    ".png": _is_picture,
    ".gif": _is_picture,
    ".pdf": _ends_with(b"%%EOF"),
    ".parquet": _is_parquet,
    ".tex": _ends_with(rb"\end{tabular}"),
}


def faults(
    command: Command,
    done: subprocess.CompletedProcess[str],
    out: Path,
    before: dict[str, bytes],
) -> list[str]:
    """Return what is wrong after a command for which the disk was too small."""
    found = []
    said = done.stderr.strip()
    if done.returncode == 0:
        found.append("exit code 0")
    if done.returncode < 0:
        found.append(f"died of signal {-done.returncode}")
    if "Traceback" in said:
        found.append(f"a traceback: {said.splitlines()[-1][:120]}")
    if str(out) not in said:
        found.append(f"no file is named: {said[-120:]!r}")
    after = contents(out)
    found += [f"a draft is left: {name}" for name in after if ".posflock." in name]
    found += [
        f"half a file: {name}"
        for name, content in after.items()
        if before.get(name) != content and not is_whole(out / name)
    ]
    if command.replaces:
        lost = [name for name in before if name not in after]
        found += [f"an earlier result is lost: {name}" for name in lost]
    return found


def tried(command: Command, disk: Path, work: Path, steps: int) -> tuple[int, list[str]]:
    """Try a command with ever more room; return how often it was full, and what went wrong."""
    out = disk / "out"
    out.mkdir()
    done = posflock(command.words, out, work)
    if done.returncode not in (0, 1):
        return 0, [f"fails with room enough: {done.stderr[-200:]!r}"]
    before = contents(out)
    needed = sum(-(-len(content) // PAGE) + 1 for content in before.values()) * PAGE
    full, wrong = 0, []
    for step in range(steps):
        if not command.replaces:
            shutil.rmtree(out)
            out.mkdir()
        elif contents(out) != before:
            shutil.rmtree(out)
            posflock(command.words, _made(out), work)
            before = contents(out)
        filler = disk / "filler"
        _fill(filler, disk, free=needed * step // steps)
        done = posflock(command.words, out, work)
        filler.unlink()
        if done.returncode == 0:
            continue  # it needs less room than its results take
        full += 1
        found = faults(command, done, out, before if command.replaces else {})
        wrong += [f"{needed * step // steps} bytes free: {fault}" for fault in found]
        if command.name == "sweep":
            wrong += _resumed(command, out, work)
    shutil.rmtree(out)
    return full, wrong


def _made(folder: Path) -> Path:
    folder.mkdir(exist_ok=True)
    return folder


def _fill(filler: Path, disk: Path, free: int) -> None:
    """Take all of a disk but so many bytes."""
    left = shutil.disk_usage(disk).free - free
    with filler.open("wb") as file:
        os.posix_fallocate(file.fileno(), 0, max(left, 1))


def _resumed(command: Command, out: Path, work: Path) -> list[str]:
    """Return what is wrong when a sweep goes on after its disk was full."""
    rows = sum(path.read_bytes().count(b"\n") for path in out.glob("store/rows-*"))
    done = posflock([*command.words, "--json"], out, work)
    if done.returncode != 0:
        return [f"does not go on: {done.stderr[-120:]!r}"]
    found = json.loads(done.stdout)["found"]
    return [] if found >= rows - 1 else [f"{rows} rows were finished, {found} are found"]


def inside(options: argparse.Namespace) -> int:
    """Mount the small disk and try every command on it."""
    begun, counts, wrong = time.perf_counter(), Counter[str](), []
    with tempfile.TemporaryDirectory() as place:
        work, disk = Path(place) / "work", Path(place) / "disk"
        work.mkdir()
        disk.mkdir()
        mount = ["mount", "-t", "tmpfs", "-o", f"size={DISK}", "tmpfs", str(disk)]
        subprocess.run(mount, check=True)
        try:
            for command in commands(work):
                if options.only and options.only not in command.name:
                    continue
                full, found = tried(command, disk, work, options.steps)
                counts[command.name] = full
                wrong += found
                line = f"full {full} of {options.steps} times, wrong {len(found)}"
                print(f"{command.name:14} {line}", *found[:8], sep="\n    ", flush=True)
        finally:
            subprocess.run(["umount", str(disk)], check=True)
    print(f"{counts.total()} full disks in {time.perf_counter() - begun:.0f} s")
    print(f"wrong: {len(wrong)}, at most 0")
    return 1 if wrong else 0


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--steps", type=int, default=STEPS)
    parser.add_argument("--only", help="the commands whose names hold this")
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.inside:
        return inside(options)
    again = [sys.executable, __file__, "--inside", *sys.argv[1:]]
    return subprocess.run(["unshare", "--map-root-user", "--mount", *again], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
