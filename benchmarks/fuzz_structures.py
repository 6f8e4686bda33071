"""Two thousand files that are sound as files and wrong in what they say: all named, none costly.

Where `fuzz_readers` damages bytes, this writes with the formats' own libraries what no program of
ours would: arrays of other types and shapes, archives with members of wrong kinds, HDF5 with links,
tables with cells missing, doubled or absurd, bags and MCAP with other messages (`fuzz_forms`),
descriptions with values of other types, studies, profiles and manifests with wrong keys and values.
Each is read under the same limits, some with options that do not fit.

    python benchmarks/fuzz_structures.py [FILES] [--first N] [--keep FOLDER] [--seed N]
"""

from __future__ import annotations

import json
import sys
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from fuzz_forms import ABSURD, Rng, mcap, pick, ros_bag, sheet, spoil, zipped
from fuzzing import NAMED_ERROR, RECORDING, One, attempt, main_of

FILES = 2_000


def array(rng: Rng) -> np.ndarray[Any, Any]:
    """Return an array that may be poses, times, or neither."""
    n, k = int(pick(rng, (0, 1, 2, 3, 40))), int(pick(rng, (0, 1, 3, 7, 300)))
    shapes = ((n, 3, k), (3, k, n), (n, k), (n,), (), (n, 3 * k + 1), (3, 3, 3), (1, n, 3, k))
    shape = pick(rng, shapes)
    kinds = ("f8", "f4", "i1", "u8", "b1", "c16", "U3", "S2", "m8[s]", "M8[s]", ">f8", "f2")
    kind = pick(rng, kinds)
    with np.errstate(all="ignore"):
        values = rng.normal(size=shape) * pick(rng, (1.0, 1e-300, 1e300))
        values = np.where(rng.random(shape) < pick(rng, (0.0, 0.0, 0.3)), np.nan, values)
        if kind[-1] == "]":
            return np.zeros(shape, kind)
        return np.nan_to_num(values, posinf=0, neginf=0).astype(kind) if kind[0] in "iub" else (
            values.astype(kind)
        )  # fmt: skip


def names(rng: Rng) -> list[str]:
    """Return what the arrays of a file are called."""
    known = ["t", "time", "poses", "x", "y", "theta", "dt", "command", "status", "intervention",
             "clearance", "real_time", "posflock_parameters", "Poses", "a/b", "é"]  # fmt: skip
    return list(rng.choice(known, size=int(rng.integers(0, 6)), replace=False))


def npy(rng: Rng, work: Path) -> Path:
    """Write one array, plain or structured, or a header that promises another."""
    path = work / "file.npy"
    if rng.random() < 0.4:
        fields = [(name, pick(rng, ("f8", "U8", "(3,2)f8", "(2,2)f8", "O", "i2", "(0,)f8")))
                  for name in ["t", "pose", "command", "status", "intervention", "clearance"]
                  if rng.random() < 0.95]  # fmt: skip
        rows = np.zeros(int(pick(rng, (0, 1, 5))), fields or [("t", "f8")])
        np.save(path, rows, allow_pickle=True)
    else:
        np.save(path, array(rng))
    if rng.random() < 0.3:
        content = path.read_bytes()
        new = pick(rng, (b"(99999999999,)", b"(-1,)", b"(2, 2)", b"(1e9,)", b"()", b"(True,)"))
        begin = content.find(b"(", content.find(b"shape"))
        end = content.find(b")", begin) + 1
        if 0 < begin < end:
            path.write_bytes(content[:begin] + new + content[end:])
    return path


def npz(rng: Rng, work: Path) -> Path:
    """Write an archive with arrays of any kind, members that are none, or a name twice."""
    path = work / "file.npz"
    np.savez(path, **{name.replace("/", "_"): array(rng) for name in names(rng)})
    with zipfile.ZipFile(path, "a") as archive:
        if rng.random() < 0.3:
            archive.writestr(pick(rng, ("poses.npy", "../x.npy", "/abs.npy", "t.npy", "a.txt")),
                             pick(rng, (b"", b"x", b"\x93NUMPY", bytes(1 << 20))))  # fmt: skip
    return path


def mat(rng: Rng, work: Path) -> Path:
    """Write a MATLAB 5 file with arrays, structures, cells and texts."""
    from scipy.io import savemat

    path = work / "file.mat"
    variables: dict[str, Any] = {}
    for name in names(rng):
        plain = "".join(c for c in name if c.isalnum()) or "v"
        variables[plain] = pick(rng, (array, _struct, _cell))(rng)
    variables = {k: v for k, v in variables.items() if getattr(v, "dtype", None) is None
                 or v.dtype.kind not in "mM"}  # fmt: skip
    savemat(path, variables, do_compression=bool(rng.random() < 0.5))
    return path


def _struct(rng: Rng) -> Any:
    return {"poses": np.zeros((3, 2, 5)), "t": "text"}


def _cell(rng: Rng) -> Any:
    return np.array([np.zeros(3), "x"], dtype=object)


def hdf5(rng: Rng, work: Path) -> Path:
    """Write HDF5 with groups, links that lead nowhere or in circles, and claims of terabytes."""
    import h5py

    path = work / "file.mat"
    with h5py.File(path, "w", userblock_size=int(pick(rng, (0, 512)))) as file:
        for name in names(rng):
            kind = int(rng.integers(0, 7))
            if kind == 0:
                file.create_group(name)
            elif kind == 1:
                file[name] = h5py.SoftLink(pick(rng, ("/" + name, "/none", "/")))
            elif kind == 2:
                file[name] = h5py.ExternalLink(pick(rng, ("none.h5", str(path))), "/t")
            elif kind == 3:
                file.create_dataset(name, (1 << 20, 1 << 20), "f8", chunks=(1024, 1024))
            elif kind == 4:
                file.create_dataset(name, data="text")
            elif kind == 5:
                file.create_dataset(name, data=h5py.Empty("f8"))
            else:
                values = array(rng)
                if values.dtype.kind not in "UmM":
                    file[name] = values
                    file[name].attrs["MATLAB_empty"] = pick(rng, (0, 1, "x", [1, 2]))
    return path


def table(rng: Rng, work: Path) -> Path:
    """Write a table of which some cells, lines or names are not what they should be."""
    path, robots = work / "file.csv", int(rng.integers(1, 4))
    mark = pick(rng, (",", ";", "\t", " "))
    head = ["t", *(f"{s}{k}" for k in range(robots) for s in ("x", "y", "theta"))]
    rows = [
        [f"{0.1 * k:.3f}", *(f"{v:.3f}" for v in rng.normal(size=3 * robots))] for k in range(9)
    ]
    lines = [head, *rows] if rng.random() < 0.7 else rows
    spoil(rng, lines)
    end = pick(rng, ("\n", "\r\n", "\r", "\u2028"))
    text = end.join(mark.join(line) for line in lines) + pick(rng, ("", end))
    if rng.random() < 0.3:
        said = {"posflock_rows": pick(rng, ABSURD), "ended": pick(rng, ABSURD)}
        text = f"# posflock_parameters: {json.dumps(said)}{end}" + text
    path.write_bytes(text.encode(pick(rng, ("utf-8", "utf-8-sig", "utf-16", "utf-8"))))
    return path


def sidecar(rng: Rng, work: Path) -> Path:
    """Write a sound log whose description has values of other types."""
    from posflock_robotarium.flocking.pose_log import PoseLog

    with PoseLog(work / "file", 2, 40) as log:
        for k in range(40):
            poses = [[0.01 * k] * 2, [0.0, 0.3], [0.0] * 2]
            log.append(0.1 * k, poses, np.zeros((2, 2)), real_time=0.11 * k)
    said = json.loads(log.sidecar.read_text())
    for _ in range(int(rng.integers(1, 4))):
        named = ["robot", "simulated", "duration", "neighbour_radius", "walls", "drive"]
        key = pick(rng, [*said, *named])
        said[key] = pick(rng, (*ABSURD, {"how": pick(rng, ABSURD), "rows": pick(rng, ABSURD)}))
    text = json.dumps(said if rng.random() < 0.9 else pick(rng, ABSURD))
    if rng.random() < 0.1:
        text = "[" * 100_000
    log.sidecar.write_text(text)
    return log.path


def toml_value(value: Any) -> str:
    """Write a value as TOML has it, where it has it."""
    if isinstance(value, float):
        return repr(value).replace("e+", "e")
    return "{}" if value is None or value == {} else json.dumps(value)


def study(rng: Rng, work: Path) -> Path:
    """Write a study with keys and values that it cannot have."""
    lines = ['experiment = "freespace"', "replications = 2", "[parameters]", "agents = 4"]
    keys = ("agents", "side", "duration", "time_step", "record_interval", "radius", "delay", "seed")
    for _ in range(int(rng.integers(1, 4))):
        line = f"{pick(rng, keys)} = {toml_value(pick(rng, ABSURD))}"
        lines.insert(int(rng.integers(0, len(lines) + 1)), line)
    if rng.random() < 0.5:
        lines += ["[grid]", f"persistence = {toml_value([pick(rng, ABSURD), 0.1])}"]
    if rng.random() < 0.5:
        kind = pick(rng, ("uniform", "normal", "loguniform", "choice", "x"))
        values = toml_value([pick(rng, ABSURD), 1.0])
        lines += ["[distributions]", f"distance_scale = {{ {kind} = {values} }}"]
    (work / "file.toml").write_text("\n".join(lines), "utf-8")
    return work / "file.toml"


def profile(rng: Rng, work: Path) -> Path:
    """Write a profile with keys and values that it cannot have."""
    from rps_compat.profiles import profile_text

    lines = profile_text(pick(rng, ("gritsbot_x", "harsh"))).splitlines()
    for _ in range(int(rng.integers(1, 4))):
        at = int(rng.integers(0, len(lines)))
        key = lines[at].partition("=")[0].strip() or "x"
        lines[at] = pick(rng, (f"{key} = {toml_value(pick(rng, ABSURD))}", "[x]", lines[at - 1]))
    (work / "file.toml").write_text("\n".join(lines), "utf-8")
    return work / "file.toml"


def manifest(rng: Rng, work: Path) -> Path:
    """Write a manifest with names and values that it cannot have."""
    head = {"schema": "posflock bundle 1", "main": "main.py", "robots": 3, "duration": 100.0}
    for _ in range(int(rng.integers(0, 3))):
        head[pick(rng, list(head))] = pick(rng, ABSURD)
    lines = [f"{'0' * 64}  main.py"]
    strange = ("../x.py", "/etc/passwd", "MAIN.py", "x\x1b.py", "", "MANIFEST", "a\\b", "é" * 200)
    lines += [f"{'0' * 64}  {pick(rng, strange)}" for _ in range(int(rng.integers(0, 3)))]
    (work / "MANIFEST").write_text(f"# {json.dumps(head)}\n" + "\n".join(lines) + "\n", "utf-8")
    return work / "MANIFEST"


def _analysed(path: Path) -> object:
    from posflock_robotarium.report import analyse

    return json.dumps(analyse(path, radius=0.75).summary(), allow_nan=False)


def _sound_study(path: Path) -> object:
    from posflock_robotarium.sweep.study import read_study

    return read_study(path).runs()


def _sound_profile(path: Path) -> object:
    from rps_compat.profiles import load_profile

    motors = load_profile(path).start()
    return motors


def _sound_manifest(path: Path) -> object:
    from posflock_robotarium.submission.manifest import read_manifest

    return read_manifest(path.parent)


Make = Callable[[Rng, Path], Path]
LOGS: tuple[Make, ...] = (npy, npz, mat, hdf5, table, sheet, sheet, mcap, ros_bag, zipped)
OTHERS: dict[Make, Callable[[Path], object]] = {
    sidecar: _analysed, study: _sound_study, profile: _sound_profile, manifest: _sound_manifest,
}  # fmt: skip


def options(rng: Rng) -> dict[str, Any]:
    """Return what somebody says about a log, mostly nothing."""
    from posflock_robotarium.logs.readers import Lengths, LogClock

    said: dict[str, Any] = {}
    if rng.random() < 0.2:
        said["units"] = pick(rng, tuple(Lengths))
        said["degrees"] = bool(rng.random() < 0.5)
    if rng.random() < 0.2:
        said["clock"] = pick(rng, tuple(LogClock))
        said["drop_damaged"] = bool(rng.random() < 0.5)
    if rng.random() < 0.2:
        said["array"] = pick(rng, ("/r1/pose", "poses", "x", "", "é"))
    if rng.random() < 0.2:
        said["columns"] = pick(rng, ("state", "robot", "t,x1,y1,theta1", "t,x1,y1", "-", ",", "é"))
    return said


def structured(folder: Path, seed: int) -> One:
    """Return what writes a file that is wrong in what it says, and reads it."""
    from barrier_certificates.certificate_errors import PosflockError

    makers = (*LOGS, *OTHERS)

    def one(number: int, work: Path) -> tuple[str, str]:
        make, rng = makers[number % len(makers)], np.random.default_rng([seed, number])
        with warnings.catch_warnings():  # of libraries that are asked to write nonsense
            warnings.simplefilter("ignore")
            path = make(rng, work)
        if make not in OTHERS:
            return make.__name__, attempt(path, **options(rng))
        try:
            OTHERS[make](path)
        except PosflockError as error:
            named = path.stem in str(error)
            return make.__name__, NAMED_ERROR if named else f"nameless error: {error}"
        except Exception as error:
            return make.__name__, f"unnamed {type(error).__name__}: {error}"
        return make.__name__, RECORDING

    # What is imported for the first of each kind is not to be imported in every child.
    for number in range(len(makers)):
        (folder / str(number)).mkdir()
        one(number, folder / str(number))
    return one


if __name__ == "__main__":
    sys.exit(main_of(__doc__, FILES, structured))
