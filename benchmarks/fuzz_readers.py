"""Twenty thousand damaged files: a named error or a sound recording, no crash, hang or gigabytes.

Files of every kind that the readers know are damaged (bytes flipped, cut, doubled, spliced, numbers
in headers changed) and read in child processes with a limit on memory and time. A child that dies
is a crash or a hang of the reader: it is counted, the file is kept, and the rest goes on.

    python benchmarks/fuzz_readers.py [FILES] [--keep FOLDER] [--seed N]
"""

from __future__ import annotations

import argparse
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
from pathlib import Path

import numpy as np

FILES = 20_000
BATCH = 400
MOST_MEMORY = 2 << 30
"""Bytes of address space of a child, libraries included: what a damaged header may not take."""

MOST_SECONDS = 20
"""For one file, on a machine with other work; sound files of this size take milliseconds."""

STEP = 0.033
GOOD = ("named error", "recording")


def seeds(folder: Path) -> list[Path]:
    """Write one sound file of each kind."""
    import h5py
    from scipy.io import savemat

    from posflock_robotarium.alignment.truth import known_flock
    from posflock_robotarium.flocking.pose_log import PoseLog

    recording = known_flock("rotating", 0.1, robots=4, duration=2.0).recording
    t, poses = recording.t, recording.poses
    flat = np.column_stack([t, poses.transpose(0, 2, 1).reshape(len(t), -1)])
    header = "t," + ",".join(f"{s}{i}" for i in range(1, 5) for s in ("x", "y", "theta"))
    with PoseLog(folder / "log", 4, len(t), {"neighbour_radius": 0.75, "seed": 1}) as log:
        for k in range(len(t)):
            sent = np.zeros((2, 4))
            log.append(
                t[k], poses[k], sent, real_time=1.04 * t[k], status="optimal", intervention=0.0
            )
    np.save(folder / "plain.npy", poses)
    np.save(folder / "flat.npy", flat)
    np.savez(folder / "stored.npz", t=t, poses=poses)
    np.savez_compressed(folder / "packed.npz", t=t, x=poses[:, 0], y=poses[:, 1], theta=poses[:, 2])
    savemat(folder / "five.mat", {"t": t, "poses": poses.transpose(1, 2, 0), "name": "run"})
    savemat(folder / "packed.mat", {"t": t, "poses": poses}, do_compression=True)
    with h5py.File(folder / "seven.mat", "w", userblock_size=512) as file:
        file["t"] = t[:, np.newaxis]
        file.create_dataset("poses", data=poses.transpose(0, 2, 1), compression="gzip")
    np.savetxt(folder / "header.csv", flat, delimiter=",", header=header, comments="")
    np.savetxt(folder / "blank.txt", flat, fmt="%.6g")
    rows = ["t;robot;x;y;theta"]
    rows += [f"{t[k]:.4f};{i};{poses[k, 0, i]:.5f};{poses[k, 1, i]:.5f};{poses[k, 2, i]:.5f}"
             for k in range(len(t)) for i in range(4)]  # fmt: skip
    (folder / "long.csv").write_text("\n".join(rows))
    return sorted(path for path in folder.iterdir())


def damage(content: bytes, other: bytes, rng: np.random.Generator) -> bytes:
    """Return the content with one to four faults, half of them among its first bytes."""
    data = bytearray(content)
    for _ in range(rng.integers(1, 5)):
        if not data:
            break
        reach = min(len(data), 600) if rng.random() < 0.5 else len(data)
        at = int(rng.integers(0, reach))
        kind = int(rng.integers(0, 9))
        length = int(rng.integers(1, 40))
        if kind == 0:
            data[at] ^= 1 << int(rng.integers(0, 8))
        elif kind == 1:
            data[at] = int(rng.choice([0, 255, 10, 44, 48, 127]))
        elif kind == 2:
            del data[at:]
        elif kind == 3:
            del data[at : at + length]
        elif kind == 4:
            data[at:at] = data[at : at + length]
        elif kind == 5:
            data[at:at] = rng.bytes(length)
        elif kind == 6:
            begin = int(rng.integers(0, max(1, len(other))))
            data[at : at + length] = other[begin : begin + length]
        elif kind == 7:
            digits = [k for k in range(reach) if 48 <= data[k] <= 57]
            if digits:
                data[digits[int(rng.integers(0, len(digits)))]] = int(rng.integers(48, 58))
        else:
            width = int(rng.choice([2, 4, 8]))
            value = int(rng.choice([0, 2**31 - 1, 2**32 - 1, 2**62, 2**64 - 1]))
            data[at : at + width] = (value % 2 ** (8 * width)).to_bytes(width, "little")
    return bytes(data)


def attempt(path: Path) -> str:
    """Read one file; return how it went."""
    from posflock_robotarium.flocking.errors import PosflockError
    from posflock_robotarium.report import ReadOptions, read

    try:
        recording = read(path, ReadOptions(dt=STEP))
    except PosflockError as error:
        return "named error" if path.stem in str(error) else f"nameless error: {error}"
    except Exception as error:
        return f"unnamed {type(error).__name__}: {error}"
    sound = (
        np.isfinite(recording.poses).all()
        and (np.diff(recording.t) > 0).all()
        and recording.poses.shape == (len(recording.t), 3, recording.robots)
    )
    return "recording" if sound else "unsound recording"


One = Callable[[int, Path], tuple[str, str]]
"""Makes one damaged file in a folder and reads it; returns its name, and how it went."""


def damaged(originals: list[Path], seed: int) -> One:
    """Return what damages the bytes of sound files and reads them."""
    contents = {path: path.read_bytes() for path in originals}

    def one(number: int, work: Path) -> tuple[str, str]:
        rng = np.random.default_rng([seed, number])
        original = originals[number % len(originals)]
        other = originals[int(rng.integers(0, len(originals)))]
        for path, content in contents.items():
            if path.stem == original.stem:
                (work / path.name).write_bytes(content)
        target = work / original.name
        target.write_bytes(damage(contents[original], contents[other], rng))
        return original.name, attempt(
            target.with_suffix(".npy") if target.suffix == ".json" else target
        )

    return one


def child(numbers: range, one: One, folder: Path, keep: Path | None, pipe: int) -> None:
    """Make and read some files; tell each outcome before the next is begun."""
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    warnings.simplefilter("error")
    work = folder / "work"
    for number in numbers:
        shutil.rmtree(work, ignore_errors=True)
        work.mkdir()
        signal.alarm(MOST_SECONDS)
        name, outcome = one(number, work)
        signal.alarm(0)
        if outcome not in GOOD:
            _keep(folder, keep, number)
        os.write(pipe, f"{number}\t{name}\t{outcome[:300]!r}\n".encode())


def run(files: int, one: One, folder: Path, keep: Path | None) -> tuple[Counter[str], list[str]]:
    """Read every damaged file; return outcomes, and what went wrong in words."""
    outcomes: Counter[str] = Counter()
    wrong: list[str] = []
    attempt(Path("nothing"))  # imports happen before the fork, not in every child
    import h5py  # noqa: F401
    import scipy.io  # noqa: F401

    number = 0
    while number < files:
        last = min(number + BATCH, files)
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
                done, name, outcome = line.rstrip("\n").split("\t", 2)
                number = int(done) + 1
                kind = outcome.strip("'\"").split(":")[0]
                outcomes[kind] += 1
                if kind not in GOOD:
                    wrong.append(f"file {done} ({name}): {outcome}")
        _, status = os.waitpid(process, 0)
        if number < last:
            how = signal.Signals(os.WTERMSIG(status)).name if os.WIFSIGNALED(status) else "exit"
            kind = "hang" if how == "SIGALRM" else f"crash {how}"
            outcomes[kind] += 1
            wrong.append(f"file {number}: {kind}")
            _keep(folder, keep, number)
            number += 1
    return outcomes, wrong


def _keep(folder: Path, keep: Path | None, number: int) -> None:
    if keep is not None and (folder / "work").is_dir():
        shutil.copytree(folder / "work", keep / str(number), dirs_exist_ok=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("files", nargs="?", type=int, default=FILES)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, help="folder for files that were read wrongly")
    options = parser.parse_args()
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "seeds").mkdir()
        one = damaged(seeds(folder / "seeds"), options.seed)
        outcomes, wrong = run(options.files, one, folder, options.keep)
    return tell(outcomes, wrong, time.perf_counter() - begun, FILES)


def tell(outcomes: Counter[str], wrong: list[str], took: float, required: int) -> int:
    """Print how it went, and return the exit code."""
    print(f"{sum(outcomes.values())} damaged files in {took:.0f} s, required {required}")
    for kind, count in outcomes.most_common():
        print(f"  {count:6d}  {kind}")
    for line in wrong[:20]:
        print(line)
    print(f"read wrongly: {len(wrong)}, at most 0")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
