"""Files of strangers: how large they may be, what they may be called, what a terminal sees."""

import ast
import json
import os
import re
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from posflock_robotarium.alignment.analysis import is_analysis
from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import LogError, ParameterError
from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.logs.readers import Bounds, Form, ReadOptions, Sign, read, registered
from posflock_robotarium.submission.bundle import bundle
from posflock_robotarium.submission.manifest import MANIFEST, BundleError, read_manifest
from posflock_robotarium.sweep.study import StudyError, read_study
from rps_compat.bounded_files import read_bounded
from rps_compat.distributions import ProfileError
from rps_compat.errors import ScriptError
from rps_compat.profiles import load_profile
from rps_compat.scripts.source import read_script
from rps_compat.terminal import printable

ROOT = Path(__file__).parents[1]
STEP = 0.033
SMALL = ReadOptions(dt=STEP, bounds=Bounds(megabytes=0.1))

# --- Sizes ----------------------------------------------------------------------------------------


def written(folder, ending):
    """Write poses of 2 robots that take 480 kB, in a form; return the path."""
    path, poses = folder / f"large{ending}", np.random.default_rng(0).normal(size=(10_000, 3, 2))
    if ending == ".npy":
        np.save(path, poses)
    elif ending == ".npz":
        np.savez_compressed(path, poses=poses)
    elif ending == ".csv":
        np.savetxt(path, poses.reshape(-1, 6), delimiter=",")
    elif ending == ".h5":
        with h5py.File(path, "w") as file:
            file.create_dataset("poses", data=poses, compression="gzip")
    else:
        from scipy.io import savemat

        savemat(path, {"poses": poses}, do_compression=True)
    return path


@pytest.mark.parametrize("ending", [".npy", ".npz", ".csv", ".mat", ".h5"])
def test_a_file_larger_than_asked_for_is_refused_with_the_option_that_reads_it(ending, tmp_path):
    path = written(tmp_path, ending)
    with pytest.raises(LogError, match=rf"large\{ending}.*more than 0\.1 MB.*--max-size"):
        read(path, SMALL)


def test_an_archive_that_unpacks_to_gigabytes_costs_nothing(tmp_path):
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("poses.npy", bytes(30 << 20))
    assert path.stat().st_size < 1 << 16
    with pytest.raises(LogError, match=r"30\.0 MB of memory, more than 16 MB"):
        read(path, ReadOptions(bounds=Bounds(megabytes=16)))


def test_a_line_without_an_end_is_refused(tmp_path):
    path = tmp_path / "line.csv"
    path.write_text("1," * 600_000)
    with pytest.raises(LogError, match=r"line\.csv: line 1: 1200000 letters"):
        read(path)


def test_two_thousand_robots_are_refused_with_the_option_that_reads_them(tmp_path):
    path, robots = tmp_path / "many.csv", 2000
    names = ",".join(f"{s}{k}" for k in range(1, robots + 1) for s in ("x", "y", "theta"))
    rows = "\n".join(f"{0.1 * k}," + ",".join(["0.5"] * 3 * robots) for k in range(3))
    path.write_text(f"t,{names}\n{rows}\n")
    with pytest.raises(LogError, match=r"many\.csv: 2000 robots.*--max-robots"):
        read(path)
    many = ReadOptions(bounds=Bounds(robots=2000))
    assert read(path, many).robots == robots
    with PoseLog(tmp_path / "log", robots, 3) as log:
        for k in range(3):
            log.append(0.1 * k, np.zeros((3, robots)), np.zeros((2, robots)))
    with pytest.raises(LogError, match="--max-robots"):
        read(log.path)
    assert read(log.path, many).robots == robots


@pytest.mark.parametrize("wrong", [{"megabytes": 0.0}, {"megabytes": np.nan}, {"robots": 0}])
def test_bounds_that_admit_nothing_are_refused(wrong):
    with pytest.raises(ParameterError, match="--max"):
        Bounds(**wrong)


def test_hdf5_does_not_read_other_files(tmp_path):
    secret = tmp_path / "secret.bin"
    np.arange(24.0).tofile(secret)
    with h5py.File(tmp_path / "other.h5", "w") as other:
        other["poses"] = np.zeros((8, 3, 1))
    with h5py.File(tmp_path / "run.mat", "w") as file:
        file.create_dataset("raw", (8, 3, 1), "f8", external=[(str(secret), 0, 192)])
        file["link"] = h5py.ExternalLink("other.h5", "poses")
        layout = h5py.VirtualLayout((8, 3, 1), "f8")
        layout[:] = h5py.VirtualSource(str(tmp_path / "other.h5"), "poses", (8, 3, 1))
        file.create_virtual_dataset("virtual", layout)
    with pytest.raises(LogError, match="no numeric variable"):
        read(tmp_path / "run.mat", ReadOptions(dt=STEP))


def test_what_no_reader_expects_names_the_file(tmp_path):
    def fails(file, options):
        raise KeyError("surprise")

    form = Form(
        "surprise", ".sur", "", Sign.ENDING, lambda file, start: file.suffix == ".sur", fails
    )
    path = tmp_path / "file.sur"
    path.write_text("x")
    with registered(form), pytest.raises(LogError, match=r"file\.sur: cannot be read \(KeyError"):
        read(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes here")
def test_a_pipe_is_an_error_and_no_wait(tmp_path):
    for name in ("run.py", "run.toml", "run.npy", "run.npz", MANIFEST):
        os.mkfifo(tmp_path / name)
    for reader, error in (
        (lambda: read_script(tmp_path / "run.py"), ScriptError),
        (lambda: load_profile(tmp_path / "run.toml"), ProfileError),
        (lambda: read_study(tmp_path / "run.toml"), StudyError),
        (lambda: read(tmp_path / "run.npy"), LogError),
        (lambda: read_manifest(tmp_path), BundleError),
        (lambda: read_bounded(Path(os.devnull)), OSError),
        (lambda: read_bounded(tmp_path), OSError),
    ):
        with pytest.raises(error):
            reader()
    assert not is_analysis(tmp_path / "run.npz")


def test_a_file_that_no_person_writes_is_too_large_to_be_a_study(tmp_path):
    with (tmp_path / "study.toml").open("wb") as file:
        file.truncate(17 << 20)  # sparse: it costs nothing
    with pytest.raises(StudyError, match="17825792 bytes, more than"):
        read_study(tmp_path / "study.toml")


# --- Names ----------------------------------------------------------------------------------------

DIGEST = "0" * 64


@pytest.mark.parametrize(
    "name",
    ["../main.py", "/etc/passwd", "a\\b.py", "C:x.py", "a\x1b[2J.py", ".", "..", " a.py", "-rf.py",
     "MANIFEST", "submit.md", "a|b.py", "x" * 300 + ".py", "a\u202eyp.exe.py"],
)  # fmt: skip
def test_a_manifest_with_names_that_are_none_is_refused(name, tmp_path):
    head = {"schema": "posflock bundle 1", "main": "main.py", "robots": None, "duration": None}
    lines = [f"# {json.dumps(head)}", f"{DIGEST}  main.py", f"{DIGEST}  {name}", ""]
    (tmp_path / MANIFEST).write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(BundleError, match="cannot be called") as caught:
        read_manifest(tmp_path)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    "change",
    [{"main": "other.py"}, {"main": ["main.py"]}, {"robots": "9"}, {"robots": True},
     {"duration": "1"}, {"duration": float("inf")}],
)  # fmt: skip
def test_a_manifest_with_values_of_other_kinds_is_refused(change, tmp_path):
    head = {"schema": "posflock bundle 1", "main": "main.py", "robots": 9, "duration": 300.0}
    (tmp_path / MANIFEST).write_text(f"# {json.dumps(head | change)}\n{DIGEST}  main.py\n")
    with pytest.raises(BundleError, match="make the bundle again"):
        read_manifest(tmp_path)


def test_a_manifest_that_is_no_text_is_refused(tmp_path):
    (tmp_path / MANIFEST).write_bytes(b"# \xff\n")
    with pytest.raises(BundleError, match="not UTF-8"):
        read_manifest(tmp_path)


@pytest.mark.parametrize(
    ("names", "reason"),
    [
        (("Goals.npy", "goals.npy"), "in its case alone"),
        (("go\nals.npy",), "cannot be printed"),
        (("json.py",), "Python's own module 'json'"),
        (("numpy.py",), "the testbed's library 'numpy'"),
        (("main.py",), "runs as main.py"),
        ((os.fsdecode(b"go\xffals.npy"),), "cannot be printed"),
    ],
)
def test_data_with_names_that_cannot_be_uploaded_is_refused_before_anything_is_written(
    names, reason, tmp_path
):
    script, data = tmp_path / "script.py", []
    script.write_text("import rps\n")
    for number, name in enumerate(names):
        (tmp_path / str(number)).mkdir()
        data.append(tmp_path / str(number) / name)
        data[-1].write_bytes(b"# data")
    with pytest.raises(BundleError, match=reason):
        bundle(script, tmp_path / "up", data=data)
    assert not (tmp_path / "up").exists()


def test_a_pipe_or_a_device_is_no_data_file(tmp_path):
    script = tmp_path / "script.py"
    script.write_text("import rps\n")
    (tmp_path / "endless.npy").symlink_to("/dev/zero")
    with pytest.raises(BundleError, match=r"endless\.npy: cannot be read \(expected a plain file"):
        bundle(script, tmp_path / "up", data=[tmp_path / "endless.npy"])


def test_an_earlier_bundle_survives_a_failed_second_one(tmp_path, monkeypatch):
    script = tmp_path / "script.py"
    script.write_text("import rps\n")
    bundle(script, tmp_path / "up")
    before = {path.name: path.read_bytes() for path in (tmp_path / "up").iterdir()}
    script.write_text("import rps\nprint(2)\n")

    def full(ready):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("posflock_robotarium.submission.bundle.instructions", full)
    with pytest.raises(OSError, match="No space left"):
        bundle(script, tmp_path / "up")
    assert {path.name: path.read_bytes() for path in (tmp_path / "up").iterdir()} == before
    assert not list(tmp_path.glob(".posflock*"))


def test_a_bundle_goes_where_a_link_leads(tmp_path):
    script, far = tmp_path / "script.py", tmp_path / "far"
    script.write_text("import rps\n")
    far.mkdir()
    (tmp_path / "up").symlink_to(far)
    bundle(script, tmp_path / "up")
    assert (tmp_path / "up").is_symlink()
    assert (far / MANIFEST).exists()


# --- The terminal ---------------------------------------------------------------------------------

COMMANDS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


def test_text_is_printed_without_its_commands_and_json_means_the_same():
    text = "\x1b]0;title\x07 \x9b2J a\rb\tc\n\u202eTXT \udcff Müller 群"
    shown = printable(text)
    assert not COMMANDS.search(shown)
    assert shown.count("\n") == text.count("\n")
    assert "Müller 群" in shown
    said = json.dumps({"a": text}, ensure_ascii=False)
    assert json.loads(printable(said)) == {"a": text}


def test_the_reason_in_a_log_commands_no_terminal(tmp_path):
    log = PoseLog(tmp_path / "run", 2, 40, {"neighbour_radius": 0.75})
    for k in range(40):
        log.append(0.033 * k, [[0.01 * k, 0.01 * k], [0.0, 0.4], [0.0, 0.0]], np.zeros((2, 2)))
    log.close("failed", "\x1b[2J\x9b31m it \x07 failed")
    for more in ([], ["--json"]):
        command = ["report", str(log.path), "-o", str(tmp_path / "out"), "--no-figures", *more]
        done = CliRunner().invoke(app, command, catch_exceptions=False)
        assert done.exit_code == 0
        assert "u001b[2J" in done.stdout
        assert not COMMANDS.search(done.stdout)


def test_commands_print_through_one_function_alone():
    folder = ROOT / "posflock_robotarium" / "commands"
    for path in [*folder.glob("*.py"), folder.parent / "cli.py"]:
        called = [
            ast.unparse(node.func)
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if isinstance(node, ast.Call)
        ]
        # The terminal itself, a version, and a script's bytes for a program that reads them.
        most = {"terminal.py": 1, "cli.py": 1, "run.py": 1}.get(path.name, 0)
        assert called.count("typer.echo") <= most, path.name
        assert "print" not in called, path.name
