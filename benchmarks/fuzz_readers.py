"""Twenty thousand damaged files: a named error or a sound recording, no crash, hang or gigabytes.

Files of every kind that the readers know are damaged (bytes flipped, cut, doubled, spliced, numbers
in headers changed) and read under the limits of `fuzzing`.

    python benchmarks/fuzz_readers.py [FILES] [--first N] [--keep FOLDER] [--seed N]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from fuzzing import One, attempt, main_of
from sound_logs import write_trackers

FILES = 20_000


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
    write_trackers(folder)
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


def damaged(folder: Path, seed: int) -> One:
    """Return what damages the bytes of sound files, which are written into a folder, and reads."""
    (folder / "seeds").mkdir()
    originals = seeds(folder / "seeds")
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


if __name__ == "__main__":
    sys.exit(main_of(__doc__, FILES, damaged))
