"""What both fuzz benchmarks read files with: child processes with limits, and an account of them.

A child makes one file after the other and reads each. It tells each outcome before it begins the
next file, so that a child that dies is a crash or a hang of the reader: it is counted, the file is
kept, and the rest goes on. The longest time and the largest memory of a read are measured, not only
capped.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from comparing import Table

BATCH = 400
MOST_ADDRESSES = 2 << 30
"""Bytes of address space of a child, libraries included: the cap on what a header may take."""

MOST_MEMORY = 1024
"""MiB that a child may have in memory at most, libraries included."""

MOST_SECONDS = 20
"""Of CPU time for one file; sound files of this size take milliseconds."""

MOST_WAITING = 200
"""Seconds for one file, on a machine with other work: a reader that waits uses no CPU time."""

STEP = 0.033
NAMED_ERROR, RECORDING = "named error", "recording"

One = Callable[[int, Path], tuple[str, str]]
"""Makes one file in a folder and reads it; returns what it is, and how that went."""


def attempt(path: Path, **said: object) -> str:
    """Read one file as somebody who says `said` does; return how it went."""
    from posflock_robotarium.flocking.errors import PosflockError
    from posflock_robotarium.logs.known_numbers import LEAST_SEEN
    from posflock_robotarium.report import ReadOptions, read

    try:
        recording = read(path, ReadOptions(**{"dt": STEP, **said}))  # type: ignore[arg-type]
    except PosflockError as error:
        return NAMED_ERROR if path.stem in str(error) else f"nameless error: {error}"
    except Exception as error:
        return f"unnamed {type(error).__name__}: {error}"
    # A cell that was emptied, or made a NaN, is a robot that was not seen, as a whole.
    places = recording.poses[:, :2]
    known = np.isfinite(places).all(axis=1)
    sound = (
        (np.isfinite(places).any(axis=1) == known).all()
        and not np.isinf(recording.poses).any()
        and known.mean() >= LEAST_SEEN
        and (np.diff(recording.t) > 0).all()
        and recording.poses.shape == (len(recording.t), 3, recording.robots)
    )
    return RECORDING if sound else "unsound recording"


@dataclass
class Account:
    """How the reading of many files went.

    Attributes
    ----------
    outcomes : Counter
        Files by how they were read.
    wrong : list of str
        What must not be, in words.
    seconds, memory : tuple of (float, str)
        The longest CPU time that making and reading a file took, s, and the most that a child had
        in memory, MiB, each with the file.
    """

    outcomes: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)
    seconds: tuple[float, str] = (0.0, "")
    memory: tuple[float, str] = (0.0, "")

    def note(self, number: int, name: str, outcome: str, seconds: float, memory: float) -> None:
        """Count one file."""
        kind = outcome.split(":")[0]
        self.outcomes[kind] += 1
        if kind not in (NAMED_ERROR, RECORDING):
            self.wrong.append(f"file {number} ({name}): {outcome}")
        self.seconds = max(self.seconds, (seconds, f"{name}, file {number}"))
        self.memory = max(self.memory, (memory, f"{name}, file {number}"))

    def lose(self, number: int, status: int) -> None:
        """Count a file at which a child died."""
        how = signal.Signals(os.WTERMSIG(status)).name if os.WIFSIGNALED(status) else "exit"
        kind = "hang" if how in ("SIGALRM", "SIGPROF") else f"crash {how}"
        self.outcomes[kind] += 1
        self.wrong.append(f"file {number}: {kind}")

    def told(self, took: float, required: int) -> int:
        """Print it, and return the exit code."""
        print(f"{self.outcomes.total()} files in {took:.0f} s")
        for kind, count in self.outcomes.most_common():
            print(f"  {count:6d}  {kind}")
        print(*self.wrong[:20], sep="\n")
        table = Table()
        table.bar("files", self.outcomes.total(), "≥", required)
        table.bar("read wrongly", len(self.wrong), "≤", 0)
        table.bar(
            "longest, CPU time", self.seconds[0], "≤", MOST_SECONDS, "s", beside=self.seconds[1]
        )
        table.bar("most memory", self.memory[0], "≤", MOST_MEMORY, "MiB", beside=self.memory[1])
        return table.exit_code()


def child(numbers: range, one: One, folder: Path, keep: Path | None, pipe: int) -> None:
    """Make and read some files; tell each outcome before the next is begun."""
    resource.setrlimit(resource.RLIMIT_AS, (MOST_ADDRESSES, MOST_ADDRESSES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    warnings.simplefilter("error")
    work = folder / "work"
    for number in numbers:
        shutil.rmtree(work, ignore_errors=True)
        work.mkdir()
        signal.setitimer(signal.ITIMER_PROF, MOST_SECONDS)
        signal.alarm(MOST_WAITING)
        begun = time.process_time()
        name, outcome = one(number, work)
        seconds = time.process_time() - begun
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.alarm(0)
        if outcome not in (NAMED_ERROR, RECORDING):
            _keep(folder, keep, number)
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        told = json.dumps([number, name, outcome[:300], seconds, memory])
        os.write(pipe, told.encode() + b"\n")


def run(files: range, one: One, folder: Path, keep: Path | None) -> Account:
    """Make and read files of these numbers; return how that went."""
    account = Account()
    attempt(Path("nothing"))  # imports happen before the fork, not in every child
    import h5py  # noqa: F401
    import scipy.io  # noqa: F401

    number = files.start
    while number < files.stop:
        last = min(number + BATCH, files.stop)
        reader, writer = os.pipe()
        process = os.fork()
        if process == 0:
            os.close(reader)
            try:
                child(range(number, last), one, folder, keep, writer)
            except BaseException:
                traceback.print_exc()
            finally:
                os._exit(0)
        os.close(writer)
        with os.fdopen(reader) as told:
            for line in told:
                done, name, outcome, seconds, memory = json.loads(line)
                account.note(done, name, outcome, seconds, memory)
                number = done + 1
        _, status = os.waitpid(process, 0)
        if number < last:
            account.lose(number, status)
            _keep(folder, keep, number)
            number += 1
    return account


def _keep(folder: Path, keep: Path | None, number: int) -> None:
    if keep is not None and (folder / "work").is_dir():
        shutil.copytree(folder / "work", keep / str(number), dirs_exist_ok=True)


def main_of(about: str | None, files: int, of: Callable[[Path, int], One]) -> int:
    """Read what the command line asks for: so many files, as `of` makes them of folder and seed."""
    parser = argparse.ArgumentParser(description=(about or "").split("\n")[0])
    parser.add_argument("files", nargs="?", type=int, default=files)
    parser.add_argument("--first", type=int, default=0, help="number of the first file")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, help="folder for files that were read wrongly")
    options = parser.parse_args()
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as place:
        one = of(Path(place), options.seed)
        numbers = range(options.first, options.first + options.files)
        account = run(numbers, one, Path(place), options.keep)
    return account.told(time.perf_counter() - begun, min(files, options.files))


if __name__ == "__main__":
    sys.exit(__doc__)
