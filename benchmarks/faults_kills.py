"""Five hundred kills: no finished result lost, no half file, no process and no folder left.

Every command is started again and again in the same folders and ended at a random moment by one of
four signals, sent to it alone or, as a terminal does, to its group. After each, its files are read
and what it has left is counted; every tenth start is let run to its end.

    python benchmarks/faults_kills.py [KILLS] [--seed N] [--only COMMAND]
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from comparing import Table

KILLS = 500
SIGNALS = (signal.SIGTERM, signal.SIGHUP, signal.SIGINT, signal.SIGKILL)
#: Seconds that a signalled command may take to end, and its keeper to clean up, on a machine with
#: other work: a sweep first writes its tables and figures.
PATIENCE = 120.0
#: One start in so many is let run to its end, and after so many it is told how far this is.
WHOLE_RUNS, TOLD = 10, 20
ROOT = Path(__file__).parents[1]
EXPERIMENT = ROOT / "experiments" / "robotarium_9bot.py"

SCRIPT = """\
import multiprocessing, os, subprocess, sys, time
import numpy as np
from rps.robotarium import Robotarium

if sys.argv[1:] and __name__ == "__main__":  # as posflock run is asked to: processes of three kinds
    other = subprocess.Popen(["sleep", "60"], start_new_session=True)
    multiprocessing.get_context("fork").Process(target=time.sleep, args=(60,), daemon=True).start()
    multiprocessing.get_context("spawn").Process(target=time.sleep, args=(60,), daemon=True).start()
r = Robotarium(number_of_robots=2, show_figure=False, initial_conditions=np.array(
    [[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
for k in range(400):
    r.get_poses()
    r.set_velocities(np.arange(2), np.array([[0.0, 0.0], [0.5, 0.5]]))
    r.step()
    if k % 50 == 0:
        np.save("now.npy", np.full(3, float(k)))
r.debug()
if sys.argv[1:]:  # Python would leave it running
    other.kill()
"""
STUDY = """\
experiment = "freespace"
replications = 5

[parameters]
agents = 9
side = 4.0
duration = 2.0

[grid]
persistence = [0.1, 0.2]
"""


@dataclass
class Command:
    """A command that is killed: how it is called, and what its files must be."""

    name: str
    place: Path
    words: Callable[[Path, int], list[str]]
    count: Callable[[Path], int] = lambda place: 0
    good: tuple[int, ...] = (0,)
    seconds: float = 0.0
    starts: int = 0
    kills: int = 0
    longest: float = 0.0
    faults: list[str] = field(default_factory=list)

    @property
    def temporary(self) -> Path:
        """Where its temporary folders are, a name by which its processes are known, too."""
        return self.place / "temporary"

    def start(self) -> subprocess.Popen[bytes]:
        """Start it in its folder."""
        self.starts += 1
        return subprocess.Popen(
            [sys.executable, "-m", "posflock_robotarium", *self.words(self.place, self.starts)],
            cwd=self.place,
            stdout=subprocess.DEVNULL,
            stderr=open(self.place / "said.txt", "wb"),
            start_new_session=True,
            env=os.environ | {"TMPDIR": str(self.temporary), "PYTHONPATH": str(ROOT)},
        )

    def prepare(self) -> None:
        """Make its folder, and let it run to its end once."""
        self.temporary.mkdir(parents=True)
        (self.place / "main.py").write_text(SCRIPT)
        (self.place / "study.toml").write_text(STUDY)
        words = ["bundle", "main.py", "-o", "upload", "--no-run"]
        subprocess.run(
            [sys.executable, "-m", "posflock_robotarium", *words],
            cwd=self.place,
            check=True,
            capture_output=True,
        )
        self.let_run()  # the first of all may prepare an environment for minutes
        self.let_run()

    def let_run(self) -> None:
        """Run it to its end, which must be a good one, and keep how long that took."""
        begun = time.monotonic()
        code = self.start().wait()
        self.seconds = time.monotonic() - begun
        if code not in self.good:
            last = (self.place / "said.txt").read_text(errors="replace").strip()[-200:]
            self.faults.append(f"next start: exit code {code}: {last}")

    def kill(self, rng: random.Random) -> None:
        """Start it, end it at a random moment, and look at what it leaves."""
        before = self.count(self.place)
        process = self.start()
        sent = rng.choice(SIGNALS)
        moment = rng.uniform(0.0, 1.1 * self.seconds)
        try:
            code = process.wait(moment)
        except subprocess.TimeoutExpired:
            self._end(process, sent, rng.random() < 0.5)
        else:  # it was faster than the signal
            if code not in self.good:
                self.faults.append(f"next start: exit code {code}")
            return
        self.kills += 1
        where = f"{sent.name} after {moment:.2f} s"
        self.faults += [f"{what}, {where}" for what in self.left()]
        self.faults += [f"half file: {what}, {where}" for what in half_files(self.place)]
        if self.count(self.place) < before:
            self.faults.append(f"lost: {before} results, now {self.count(self.place)}, {where}")

    def _end(self, process: subprocess.Popen[bytes], sent: int, as_terminal: bool) -> None:
        begun = time.monotonic()
        if as_terminal and sent != signal.SIGKILL:
            os.killpg(process.pid, sent)
        else:
            process.send_signal(sent)
        try:
            process.wait(PATIENCE)
            self.longest = max(self.longest, time.monotonic() - begun)
        except subprocess.TimeoutExpired:
            self.faults.append(f"went on after {signal.Signals(sent).name}")
            process.kill()
            process.wait()

    def left(self) -> list[str]:
        """Return what it has left, after some patience."""
        deadline = time.monotonic() + PATIENCE
        while True:
            found = [f"process: {words}" for words in processes_told_of(self.temporary)]
            found += [f"folder: {path.name}" for path in self.temporary.iterdir()]
            if not found or time.monotonic() > deadline:
                return found
            time.sleep(0.05)


def processes_told_of(folder: Path) -> Iterator[str]:
    """Yield the command lines of processes that know of a folder."""
    mark = os.fsencode(folder)
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes()
            if words and mark in words + (process / "environ").read_bytes():
                yield words.replace(b"\0", b" ").decode(errors="replace")[-100:]
        except OSError:
            continue


def half_files(place: Path) -> Iterator[str]:
    """Yield files under final names that are not whole, by what stands at their ends."""
    ends = {
        ".html": b"</html>",
        ".csv": b"\n",
        ".png": b"IEND\xaeB`\x82",
        ".pdf": b"%%EOF",
        ".parquet": b"PAR1",
        ".md": b"\n",
    }
    for path in place.rglob("*"):
        if not path.is_file() or any(part.startswith(".") for part in path.parts):
            continue
        if path.name in ("now.npy", "said.txt"):  # the script's own, which it was just writing
            continue
        try:
            content = path.read_bytes()
            if path.suffix == ".json":
                json.loads(content)
            elif path.suffix == ".npy":
                np.load(path, mmap_mode="r")
        except FileNotFoundError:
            continue
        except ValueError as error:
            yield f"{path.name}: {error}"
            continue
        if not content.rstrip(b" \r").endswith(ends.get(path.suffix, b"")) and not (
            path.suffix in (".html", ".pdf") and content.rstrip().endswith(ends[path.suffix])
        ):
            yield f"{path.name}, {len(content)} bytes"


def rows_of(place: Path) -> int:
    """Return the finished runs in the store of a study."""
    from posflock_robotarium.sweep.store import Store, StoreError

    deadline = time.monotonic() + PATIENCE
    while True:
        try:
            with Store(place / "results" / "store") as store:
                return len(store.rows)
        except StoreError:  # a process that another thread is just starting has our own lock, too
            if time.monotonic() > deadline:
                raise
            time.sleep(0.05)


def bundles_of(place: Path) -> int:
    """Return 1 if there is a bundle that may be submitted."""
    from posflock_robotarium.submission.manifest import check_manifest

    check_manifest(place / "nine")
    return 1


def commands(place: Path) -> list[Command]:
    """Return the commands that are killed, each with a folder of its own."""
    run = ["run", "--headless", "-o", "out", "main.py", "children"]
    verify = ["verify", "main.py", "-n", "1", "-o", "out"]
    return [
        Command("run", place / "run", lambda at, k: run),
        Command("verify", place / "verify", lambda at, k: verify),
        Command("bundle", place / "bundle",
                lambda at, k: ["bundle", str(EXPERIMENT), "-o", "nine"], bundles_of),
        Command("rehearse", place / "rehearse",
                lambda at, k: ["rehearse", "upload", "-o", f"back-{k}"]),
        Command("sweep", place / "sweep",
                lambda at, k: ["sweep", fresh_study(at, k), "-o", "results"], rows_of),
    ]  # fmt: skip


def fresh_study(place: Path, start: int) -> str:
    """Return a study that has a little more to compute at every start."""
    path = place / "study.toml"
    path.write_text(STUDY.replace("= 5", f"= {5 + start}"))
    return path.name


def main() -> int:
    """Kill, count, print; 1 where anything was lost or left."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("kills", nargs="?", type=int, default=KILLS)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", help="one command")
    options = parser.parse_args()
    table = Table()
    with tempfile.TemporaryDirectory(prefix="kills-") as place:
        chosen = [c for c in commands(Path(place)) if options.only in (None, c.name)]
        most = -(-options.kills // len(chosen))
        threads = [
            threading.Thread(target=work, args=(command, most, options.seed)) for command in chosen
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    for command in chosen:
        kinds = Counter(fault.partition(":")[0].partition(",")[0] for fault in command.faults)
        said = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
        beside = f"{command.seconds:.1f} s a run, ends within {command.longest:.1f} s"
        beside += f"; {said}" if said else ""
        print(f"  {command.name:9} {command.kills:4} kills, {command.starts} starts ({beside})")
        for fault in command.faults[:5]:
            print(f"    {fault}")
    faults = [fault for command in chosen for fault in command.faults]
    for kind, words in (
        ("lost", "finished results lost"),
        ("half file", "half files under a final name"),
        ("process", "processes left"),
        ("folder", "temporary folders left"),
        ("went on", "commands that a signal did not end"),
        ("next start", "next starts that did not work"),
    ):
        table.bar(words, sum(fault.startswith(kind) for fault in faults), "≤", 0)
    table.bar("kills", sum(command.kills for command in chosen), "≥", options.kills)
    return table.exit_code()


def work(command: Command, kills: int, seed: int) -> None:
    """Kill one command so many times."""
    rng = random.Random(f"{command.name} {seed}")
    try:
        command.prepare()
        while command.kills < kills:
            if command.starts % WHOLE_RUNS == 0:
                command.let_run()
            else:
                command.kill(rng)
            if command.starts % TOLD == 0:
                told = f"{command.kills} kills, {len(command.faults)} faults"
                print(f"    {command.name}: {told}", file=sys.stderr, flush=True)
    except Exception as error:
        command.faults.append(f"next start: {type(error).__name__}: {error}")


if __name__ == "__main__":
    sys.exit(main())
