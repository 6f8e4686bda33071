"""Logs that are written a little otherwise: each is read rightly, or told what it is."""

from __future__ import annotations

import gzip

import numpy as np
import pytest
import scipy.io

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers import LayoutError, ReadOptions, read
from posflock_robotarium.logs.readers.layouts import to_states

SAMPLES, ROBOTS = 40, 2
T = 0.033 * np.arange(SAMPLES)


def rolling(robots=ROBOTS):
    """Poses (T, 3, N) of robots that drive along their headings."""
    turn = np.linspace(-0.4, 0.5, robots)
    heading = np.linspace(-1.0, 2.0, robots) + np.outer(T, turn)
    way = np.cumsum(0.1 * 0.033 * np.stack([np.cos(heading), np.sin(heading)], axis=1), axis=0)
    places = np.stack([np.linspace(-0.8, 0.8, robots), np.linspace(0.4, -0.3, robots)])
    return np.concatenate([places + way, heading[:, np.newaxis]], axis=1)


POSES = rolling()
WITH_COMMANDS = np.concatenate([POSES, np.full((SAMPLES, 2, ROBOTS), 0.1)], axis=1)


def table(separator=",", *, names=("x{}", "y{}", "theta{}"), values=POSES, time="t", times=None):
    """One row a sample, as text."""
    heads = [time] + [name.format(n) for n in range(ROBOTS) for name in names]
    rows = [separator.join(heads)]
    stamps = [f"{t:.3f}" for t in T] if times is None else times
    for stamp, pose in zip(stamps, values, strict=True):
        rows.append(separator.join([stamp, *(f"{v:.6f}" for v in pose.T.ravel())]))
    return "\n".join(rows) + "\n"


def quaternions():
    half = POSES[:, 2] / 2
    turned = np.stack([0 * half, 0 * half, np.sin(half), np.cos(half)], axis=1)
    return np.concatenate([POSES[:, :2], turned], axis=1)


QUATERNION_NAMES = ("x{}", "y{}", "qx{}", "qy{}", "qz{}", "qw{}")
MILLIMETRES = POSES * np.array([1000.0, 1000.0, 180 / np.pi])[:, np.newaxis]
CLOCK = [f"23:59:{59 + t:09.6f}" if t < 1 else f"00:00:{t - 1:09.6f}" for t in T]
DATES = [f"2026-06-11T14:03:{t:06.3f}Z" for t in T]
BELOW = table().replace("\n", "\ns,mm,mm,deg,mm,mm,deg\n", 1).split("\n", 2)[:2]

READ = {
    "tabs and decimal commas": table("\t").replace(".", ","),
    "bars": table("|"),
    "Excel says its separator": "sep=;\n" + table(";"),
    "units below the header": "\n".join([*BELOW, table(values=MILLIMETRES).split("\n", 1)[1]]),
    "units before the number": table(names=("x_mm{}", "y_mm{}", "theta_deg{}"), values=MILLIMETRES),
    "slashes": "// of Thursday\n" + table(),
    "titles": "Experiment 3, run 2\nDate: 2026-06-11\n\n" + table(),
    "a comment in words": "% t x y theta of each\n" + table().split("\n", 1)[1],
    "x_robot_0": table(names=("x_robot_{}", "y_robot_{}", "orientation_robot_{}")),
    "quaternions": table(names=QUATERNION_NAMES, values=quaternions()),
    "dates": table(time="timestamp", times=DATES),
    "a time of day past midnight": table(time="time", times=CLOCK),
    "minutes": table(time="time_min", times=[f"{t / 60:.9f}" for t in T]),
    "UTF-16 without its mark": table().encode("utf-16-le"),
}


@pytest.mark.parametrize("text", READ.values(), ids=READ)
def test_a_table_written_otherwise_is_the_same_run(text, tmp_path):
    file = tmp_path / "log.csv"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    run = read(file)
    np.testing.assert_allclose(run.t - run.t[0], T, atol=1e-4)
    np.testing.assert_allclose(run.poses, POSES, atol=1e-5)


def test_a_failed_formula_is_unknown_and_a_quoted_number_sign_no_comment(tmp_path):
    file = tmp_path / "log.csv"
    rows = [
        f'"Robot #{n + 1}",{T[k]:.3f},' + ",".join(f"{v:.6f}" for v in POSES[k, :, n])
        for k in range(SAMPLES)
        for n in range(ROBOTS)
    ]
    rows[3] = rows[3].rsplit(",", 1)[0] + ",#N/A"
    file.write_text("id,t,x,y,theta\n" + "\n".join(rows) + "\n")
    run = read(file)
    assert np.argwhere(np.isnan(run.poses[:, 2])).tolist() == [[1, 1]]
    np.testing.assert_allclose(run.poses[2:], POSES[2:], atol=1e-5)


@pytest.mark.parametrize(
    ("start", "told"),
    [
        (gzip.compress(b"t,x,y\n", mtime=0), "compressed with gzip: unpack it first"),
        (b'{"t": [0, 1]}', "JSON: write its poses as CSV"),
        (b"<!DOCTYPE html>", "a web page or XML, no log"),
        (b"run.csv".ljust(257, b"\0") + b"ustar", "a tar archive"),
        (b"PAR1....", "a Parquet file"),
    ],
)
def test_what_is_no_log_is_told_what_it_is(start, told, tmp_path):
    file = tmp_path / "log.txt"
    file.write_bytes(start)
    with pytest.raises(LogError, match=told):
        read(file)


@pytest.mark.parametrize("order", ["N,{},T", "N,T,{}", "{},T,N", "T,{},N", "{},N,T", "T,N,{}"])
@pytest.mark.parametrize("states", [2, 3, 5])
def test_any_order_of_three_axes_is_found(order, states):
    axes = [{"T": 0, "N": 2}.get(axis, 1) for axis in order.split(",")]
    values = np.concatenate([rolling(4), np.full((SAMPLES, 2, 4), 0.1)], axis=1)[:, :states]
    poses, commands, _ = to_states(values.transpose(axes), "array", samples=SAMPLES)
    np.testing.assert_array_equal(poses[:, : min(states, 3)], values[:, :3])
    assert np.isnan(poses[:, 2]).all() == (states == 2)
    assert (commands is not None) == (states == 5)


def test_samples_and_robots_that_slide_when_exchanged_are_asked_for():
    rng = np.random.default_rng(0)
    with pytest.raises(LayoutError, match="sideways"):
        to_states(rng.uniform(-1, 1, (9, 3, 60)), "many")


@pytest.mark.parametrize("upright", [True, False])
def test_matlabs_own_log_is_read_when_it_was_turned_over(upright, tmp_path):
    values = WITH_COMMANDS.transpose(0, 2, 1).reshape(SAMPLES, -1)
    file = tmp_path / "run.mat"
    scipy.io.savemat(file, {"robotarium_data": values.T if upright else values})
    run = read(file, ReadOptions(dt=0.033))
    np.testing.assert_allclose(run.poses, POSES)
    assert any("as the testbed's MATLAB interface writes" in note for note in run.notes)


def test_an_array_a_robot_is_one_run(tmp_path):
    file = tmp_path / "run.npz"
    np.savez(file, t=T, **{f"robot{n}": POSES[:, :, n] for n in range(ROBOTS)})
    np.testing.assert_array_equal(read(file).poses, POSES)


@pytest.mark.parametrize("separator", [" ", ","])
def test_a_body_that_tilts_has_no_heading(separator, tmp_path):
    file = tmp_path / "tum.txt"
    x, y = POSES[:, :2, 0].T
    roll = np.linspace(0.0, 1.0, SAMPLES)
    still = np.zeros(SAMPLES)
    for tilt in (still, roll):
        turned = [np.sin(tilt / 2), still, still, np.cos(tilt / 2)]
        rows = np.stack([T, x, y, still, *turned], axis=1)
        np.savetxt(file, rows, fmt="%.8f", delimiter=separator)
        run = read(file)
        assert run.headed == (tilt is still)
        assert any("headings are left out" in note for note in run.notes) == (tilt is roll)


def test_commands_that_are_none_are_unknown_and_the_others_count(tmp_path):
    from posflock_robotarium.report import analyse

    t = 0.033 * np.arange(300)
    commands = np.zeros((300, 2, 2))
    commands[:, 0] = 0.08 * np.sign(np.sin(t))[:, np.newaxis]
    poses = np.zeros((300, 3, 2))
    poses[1:, 0] = np.cumsum(0.033 * commands[:-1, 0], axis=0)
    poses[:, 1] = [0.3, -0.3]
    commands[100, :, 1], commands[101, 0, 1], commands[-1] = np.nan, 1e200, np.nan
    file = tmp_path / "run.npz"
    np.savez(file, t=t, poses=poses, commands=commands)
    run = read(file)
    assert np.argwhere(np.isnan(run.commands[:, 0])).tolist() == [
        [100, 1], [101, 1], [299, 0], [299, 1]
    ]  # fmt: skip
    assert sum("4 of 600 commands are no numbers" in note for note in run.notes) == 1
    analysis = analyse(run)
    assert analysis.numbers["fastest_wheel"].value == pytest.approx(0.08 / 0.016)
    assert np.isnan(analysis.curves["fastest_wheel"][-1])
    assert [gain.gain.value for gain in analysis.following.speed] == pytest.approx([1, 1], abs=0.01)


def test_a_log_txt_beside_files_that_are_named_is_read(tmp_path):
    for name, values in (("x", POSES[:, 0]), ("y", POSES[:, 1]), ("theta", POSES[:, 2])):
        np.save(tmp_path / f"{name}.npy", values)
    (tmp_path / "log.txt").write_text("KeyboardInterrupt\n")
    from posflock_robotarium.logs.readers.reading import read_parts

    files = [tmp_path / f"{name}.npy" for name in ("x", "y", "theta")]
    assert read_parts(files, ReadOptions(dt=0.033)).printed is not None


def test_robots_that_a_file_counts_from_one_are_told(tmp_path):
    file = tmp_path / "log.csv"
    file.write_text("t,x1,y1,x2,y2\n" + "".join(f"{t:.3f},0,0,1,{t:.3f}\n" for t in T))
    assert any("robot 1 of the file is robot 0 here" in note for note in read(file).notes)


def test_a_folder_is_read_past_its_notes(tmp_path):
    (tmp_path / "log.csv").write_text(table())
    (tmp_path / "report.txt").write_text("Your simulation took 48 s.\nNo errors in it!\n")
    np.testing.assert_allclose(read(tmp_path).poses, POSES, atol=1e-5)
