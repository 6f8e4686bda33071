"""Poses in any of the forms in which scripts leave them are read alike, and damage is named."""

import json
import pickle
import warnings
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import loadmat, savemat
from typer.testing import CliRunner

from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import LogError, ParameterError
from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.logs.readers import (
    Bounds,
    Form,
    Found,
    Sign,
    form_of,
    known_forms,
    register,
    registered,
)
from posflock_robotarium.logs.readers.layouts import sideways_share, to_poses
from posflock_robotarium.logs.readers.matlab5 import read_matlab5
from posflock_robotarium.report import LayoutError, ReadOptions, Run, read, read_parts

STEP = 0.033


def rolling(samples=40, robots=4):
    """Robots that drive on arcs: what real wheels do."""
    t = np.arange(samples) * STEP
    turn = np.linspace(-0.3, 0.3, robots)
    heading = np.linspace(0, 5, robots) + turn * t[:, np.newaxis]
    start = np.linspace(-1, 1, robots)
    step = (
        0.1
        * STEP
        * np.stack([np.cos(heading + 0.5 * turn * STEP), np.sin(heading + 0.5 * turn * STEP)], 1)
    )
    place = np.cumsum(step, axis=0) - step + np.stack([start, -0.5 * start])
    return t, np.concatenate([place, heading[:, np.newaxis]], axis=1)


T, POSES = rolling()


def flat(order):
    if order == "state":
        return POSES.reshape(len(POSES), -1)
    return POSES.transpose(0, 2, 1).reshape(len(POSES), -1)


@pytest.mark.parametrize(
    ("array", "layout"),
    [
        (POSES, "T,3,N"),
        (POSES.transpose(1, 2, 0), "3,N,T"),
        (POSES.transpose(0, 2, 1), "T,N,3"),
        (flat("state"), "T,3N"),
        (flat("robot"), "T,3N"),
        (flat("state").T, "3N,T"),
        (flat("robot").T, "3N,T"),
    ],
)
def test_every_layout_of_an_array_is_recognised_and_said(tmp_path, array, layout):
    np.save(tmp_path / "run.npy", array)
    recording = read(tmp_path / "run.npy", ReadOptions(dt=STEP))
    np.testing.assert_array_equal(recording.poses, POSES)
    np.testing.assert_allclose(recording.t, T)
    assert any(f"({layout})" in note for note in recording.notes)


def test_a_shape_that_fits_twice_is_decided_by_rolling_wheels_and_the_note_says_so():
    square = np.concatenate([POSES, POSES], axis=2)[:24].reshape(24, 24)
    poses, how = to_poses(square, "square")
    assert poses.shape == (24, 3, 8)
    assert "sideways" in how


def test_a_shape_that_nothing_decides_is_asked_for():
    still = np.zeros((12, 12)) + np.arange(12)
    with pytest.raises(LayoutError, match=r"say which with --layout"):
        to_poses(still, "still")
    assert to_poses(still, "still", "T,3N", "robot")[0].shape == (12, 3, 4)


def test_more_robots_than_a_testbed_holds_need_the_layout_by_name():
    many = np.zeros((5, 3, 60))
    with pytest.raises(LayoutError, match=r"name one with --layout"):
        to_poses(many, "many")
    assert to_poses(many, "many", "T,3,N")[0].shape == (5, 3, 60)


def test_wheels_roll_and_shuffled_columns_slide():
    assert sideways_share(POSES) < 1e-6
    shuffled = POSES[:, :, [1, 2, 3, 0]].copy()
    shuffled[:, 2] = POSES[:, 2]
    assert sideways_share(shuffled) > 0.1


def test_time_is_found_in_an_array_with_one_column_more(tmp_path):
    np.save(tmp_path / "run.npy", np.column_stack([T + 7, flat("robot")]))
    recording = read(tmp_path / "run.npy")
    np.testing.assert_array_equal(recording.t, T + 7)
    np.testing.assert_array_equal(recording.poses, POSES)


def test_an_array_without_time_asks_for_the_step(tmp_path):
    np.save(tmp_path / "run.npy", POSES)
    with pytest.raises(LayoutError, match=r"--dt 0\.033"):
        read(tmp_path / "run.npy")


@pytest.mark.parametrize("names", [("t", "poses"), ("time", "x_data"), ("timestamps", "anything")])
def test_npz_by_names(tmp_path, names):
    np.savez(tmp_path / "run.npz", **{names[0]: T, names[1]: POSES.transpose(1, 2, 0)})
    np.testing.assert_array_equal(read(tmp_path / "run.npz").poses, POSES)


def test_npz_with_x_y_and_theta_apart_and_a_step(tmp_path):
    np.savez(tmp_path / "run.npz", x=POSES[:, 0], y=POSES[:, 1], theta=POSES[:, 2], dt=STEP)
    recording = read(tmp_path / "run.npz")
    np.testing.assert_array_equal(recording.poses, POSES)
    np.testing.assert_allclose(recording.t, T)


def test_npz_with_two_candidates_asks_which(tmp_path):
    np.savez(tmp_path / "run.npz", first=POSES, second=POSES, t=T)
    with pytest.raises(LayoutError, match="--array"):
        read(tmp_path / "run.npz")
    assert read(tmp_path / "run.npz", ReadOptions(array="second")).robots == 4


def test_structured_arrays_of_any_fields(tmp_path):
    rows = np.zeros(len(T), dtype=[("time", "f8"), ("poses", "f4", (3, 4))])
    rows["time"], rows["poses"] = T, POSES
    np.save(tmp_path / "run.npy", rows)
    np.testing.assert_allclose(read(tmp_path / "run.npy").poses, POSES, atol=1e-6)


def test_matlab_5_and_7_3_give_the_same(tmp_path):
    matlab = POSES.transpose(1, 2, 0)
    savemat(tmp_path / "old.mat", {"t": T[np.newaxis], "poses": matlab, "note": "hello"})
    with h5py.File(tmp_path / "new.mat", "w", userblock_size=512) as file:
        file["t"] = T[:, np.newaxis]
        file["poses"] = matlab.T  # HDF5 holds MATLAB's arrays with their axes reversed
    old, new = read(tmp_path / "old.mat"), read(tmp_path / "new.mat")
    for recording in (old, new):
        np.testing.assert_array_equal(recording.poses, POSES)
        np.testing.assert_array_equal(recording.t, T)
    assert "MATLAB 5" in old.notes[0]
    assert "MATLAB 7.3" in new.notes[0]


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("kind", ["f8", "f4", "i2", "u1", "i8"])
def test_matlab_5_arrays_are_what_scipy_reads(tmp_path, kind, packed):
    rng = np.random.default_rng(1)
    variables = {
        "cube": (100 * rng.random((3, 4, 9))).astype(kind),
        "row": np.arange(7).astype(kind),
        "one": np.array(3, dtype=kind),
        "text": "hello",
        "cell": np.array([1, "a"], dtype=object),
        "complex": np.array([1j, 2]),
        "nothing": np.zeros((0, 3)),
    }
    savemat(tmp_path / "run.mat", variables, do_compression=packed)
    ours, theirs = read_matlab5(tmp_path / "run.mat"), loadmat(tmp_path / "run.mat")
    assert set(ours) == {"cube", "row", "one", "nothing"}
    for name, array in ours.items():
        np.testing.assert_array_equal(array, theirs[name])


def test_a_matlab_file_that_ends_scipys_process_is_refused(tmp_path):
    savemat(tmp_path / "run.mat", {"poses": POSES})
    content = bytearray((tmp_path / "run.mat").read_bytes())
    at = content.index(b"poses") + 8  # the tag of the values: their type, then their length
    assert content[at : at + 4] == b"\x09\0\0\0"
    for wrong in (b"\0\0\0\0", b"\xff\xff\0\0"):
        content[at : at + 4] = wrong
        (tmp_path / "run.mat").write_bytes(content)
        with pytest.raises(LogError, match="poses: values of unknown type"):
            read(tmp_path / "run.mat", ReadOptions(dt=STEP))


def test_a_small_file_may_not_unpack_to_gigabytes(tmp_path):
    bomb = zlib.compress(bytes((1 << 20) + 64))
    head = b"MATLAB 5.0".ljust(124) + b"\x00\x01IM"
    element = np.array([15, len(bomb)], "<u4").tobytes() + bomb
    (tmp_path / "bomb.mat").write_bytes(head + element)
    with pytest.raises(LogError, match="more than 1 MB"):
        read(tmp_path / "bomb.mat", ReadOptions(dt=STEP, bounds=Bounds(megabytes=1)))


HEADERS = {
    "plain": "t,x1,y1,theta1,x2,y2,theta2,x3,y3,theta3,x4,y4,theta4",
    "underscores": "time,x_1,y_1,yaw_1,x_2,y_2,yaw_2,x_3,y_3,yaw_3,x_4,y_4,yaw_4",
    "robot first": "Time (s),"
    + ",".join(f"robot{i}_{s}" for i in range(4) for s in ("x", "y", "heading")),
    "brackets": "timestamp," + ",".join(f"{s}[{i}]" for i in range(4) for s in ("x", "y", "theta")),
}


@pytest.mark.parametrize("header", HEADERS.values(), ids=HEADERS)
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_csv_by_header(tmp_path, header, separator):
    table = np.column_stack([T, flat("robot")])
    lines = [header, *(",".join(map(repr, row)) for row in table.tolist())]
    (tmp_path / "run.csv").write_text("\n".join(lines).replace(",", separator))
    recording = read(tmp_path / "run.csv")
    np.testing.assert_array_equal(recording.poses, POSES)
    np.testing.assert_array_equal(recording.t, T)


def test_csv_columns_in_any_order_and_with_others(tmp_path):
    names = HEADERS["plain"].split(",")
    table = np.column_stack([T, flat("robot"), np.full(len(T), 12.6)])
    order = np.random.default_rng(0).permutation(14)
    lines = [[*names, "battery"], *table.astype(str)]
    (tmp_path / "run.csv").write_text("\n".join(",".join(line[k] for k in order) for line in lines))
    recording = read(tmp_path / "run.csv")
    np.testing.assert_array_equal(recording.poses, POSES)
    assert any("battery" in note for note in recording.notes)


def test_text_without_header_or_time(tmp_path):
    np.savetxt(tmp_path / "run.txt", flat("robot"), fmt="%.17g")
    recording = read(tmp_path / "run.txt", ReadOptions(dt=STEP))
    np.testing.assert_array_equal(recording.poses, POSES)


def test_numpy_savetxt_with_its_commented_header(tmp_path):
    table = np.column_stack([T, flat("robot")])
    np.savetxt(tmp_path / "run.csv", table, delimiter=",", header=HEADERS["plain"])
    np.testing.assert_array_equal(read(tmp_path / "run.csv").poses, POSES)


def test_columns_named_on_the_command_line(tmp_path):
    np.savetxt(tmp_path / "run.csv", np.column_stack([T, POSES[:, :, 0], T]), delimiter=",")
    recording = read(tmp_path / "run.csv", ReadOptions(columns="t,x,y,theta,-"))
    np.testing.assert_allclose(recording.poses[:, :, 0], POSES[:, :, 0])


def test_long_csv_with_a_row_for_each_robot(tmp_path):
    rows = ["stamp,robot_id,x,y,theta"]
    rows += [
        f"{t!r},{i},{x!r},{y!r},{h!r}"
        for t, p in zip(T.tolist(), POSES.tolist(), strict=True)
        for i, (x, y, h) in enumerate(zip(*p, strict=True))
    ]
    (tmp_path / "run.csv").write_text("\n".join(rows))
    np.testing.assert_array_equal(read(tmp_path / "run.csv").poses, POSES)
    (tmp_path / "run.csv").write_text("\n".join(rows[:-1]))
    with pytest.raises(LogError, match="there are 3 rows"):
        read(tmp_path / "run.csv")


def log_of(path, rows, **metadata):
    """Write a pose log without closing it: a process that was killed."""
    log = PoseLog(path, robots=4, steps=len(T), metadata={"neighbour_radius": 0.75, **metadata})
    for k in range(rows):
        log.append(T[k], POSES[k], np.zeros((2, 4)), status="optimal", intervention=0.01)
    return log


def test_a_pose_log_cut_off_by_a_kill_is_read_up_to_there(tmp_path):
    log_of(tmp_path / "run", 25)
    recording = read(tmp_path / "run")
    np.testing.assert_array_equal(recording.poses, POSES[:25])
    assert recording.parameters["neighbour_radius"] == 0.75
    assert any("killed" in note for note in recording.notes)
    assert any("25 of 40" in note for note in recording.notes)


def test_a_pose_log_says_how_it_ended(tmp_path):
    log_of(tmp_path / "run", 25).close("interrupted", "KeyboardInterrupt")
    assert any(
        "interrupted: KeyboardInterrupt" in note for note in read(tmp_path / "run.npy").notes
    )
    assert read(tmp_path / "run.json").robots == 4


def test_a_pose_log_with_a_hole_is_refused(tmp_path):
    log_of(tmp_path / "run", 40).close()
    rows = np.load(tmp_path / "run.npy")
    rows["t"][10] = np.nan
    np.save(tmp_path / "run.npy", rows)
    with pytest.raises(LogError, match="row 10 has no time, but row 11 has"):
        read(tmp_path / "run.npy")


def test_a_prepared_tail_that_was_never_filled_is_cut_and_said(tmp_path):
    for empty in (0.0, np.nan):
        padded = np.concatenate([POSES, np.full((10, 3, 4), empty)])
        np.save(tmp_path / "run.npy", padded)
        recording = read(tmp_path / "run.npy", ReadOptions(dt=STEP))
        assert len(recording.t) == 40
        assert any("cut at row 40 of 50" in note for note in recording.notes)


def test_parts_one_after_the_other_and_out_of_order(tmp_path):
    np.savez(tmp_path / "a.npz", t=T[:20], poses=POSES[:20])
    np.savez(tmp_path / "b.npz", t=T[20:], poses=POSES[20:])
    joined = read_parts([tmp_path / "a.npz", tmp_path / "b.npz"])
    np.testing.assert_array_equal(joined.poses, POSES)
    with pytest.raises(LogError, match="before the part before it ends"):
        read_parts([tmp_path / "b.npz", tmp_path / "a.npz"])


@pytest.mark.parametrize("prefix", ["", "run3_"])
def test_files_that_complement_each_other(tmp_path, prefix):
    parts = {"time": T, "x": POSES[:, 0], "y": POSES[:, 1], "theta": POSES[:, 2]}
    for name, array in parts.items():
        np.save(tmp_path / f"{prefix}{name}.npy", array)
    joined = read_parts([tmp_path / f"{prefix}{name}.npy" for name in parts])
    np.testing.assert_array_equal(joined.poses, POSES)
    np.testing.assert_array_equal(joined.t, T)


def test_gaps_stay_gaps():
    t = np.concatenate([T[:15], T[25:]])
    recording = Run("gap", t, np.concatenate([POSES[:15], POSES[25:]]))
    assert recording.gaps.tolist() == [15]
    assert recording.segments == [slice(0, 15), slice(15, 30)]


def test_damaged_rows_can_be_left_out_as_gaps(tmp_path):
    poses = POSES.copy()
    poses[10:20, 1, 2] = np.nan
    np.savez(tmp_path / "run.npz", t=T, poses=poses)
    with pytest.raises(LogError, match="row 10: y of robot 2 is nan"):
        read(tmp_path / "run.npz")
    recording = read(tmp_path / "run.npz", ReadOptions(drop_damaged=True))
    assert recording.gaps.tolist() == [10]
    assert len(recording.t) == 30


def write(path, text):
    path.write_text(text) if isinstance(text, str) else path.write_bytes(text)
    return path


def npy_bytes(tmp_path, array):
    np.save(tmp_path / "whole.npy", array)
    return (tmp_path / "whole.npy").read_bytes()


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("empty.csv", "", "empty"),
        ("empty.npy", b"", "empty"),
        ("blank.csv", "\n\n# nothing\n", "no row of numbers"),
        ("header.csv", "t,x,y,theta\n", "no row of numbers"),
        ("word.csv", "t,x,y,theta\n0,0,0,0\n1,0,zero,0\n", "line 3: column 3 is 'zero'"),
        ("ragged.csv", "t,x,y,theta\n0,0,0,0\n1,0,0\n", "line 3: 3 columns"),
        ("backwards.csv", "t,x,y,theta\n0,0,0,0\n2,0,0,0\n1,0,0,0\n", "row 2: time runs backwards"),
        ("standing.csv", "t,x,y,theta\n0,0,0,0\n0,0,0,0\n", "row 1: time stands still"),
        ("nan.csv", "t,x,y,theta\n0,0,0,0\n1,nan,0,0\n2,0,0,0\n", "row 1: x of robot 0 is nan"),
        ("far.csv", "t,x,y,theta\n0,0,0,0\n1,1e9,0,0\n2,0,0,0\n", "no place a robot can be"),
        ("strange.csv", "a,b,c,d\n0,0,0,0\n1,0,0,0\n", "do not say where x, y and theta are"),
        ("one.csv", "t,x,y,theta\n0,0,0,0\n", "at least 2"),
        ("binary.csv", b"\x00\x01\x02\x03" * 10, "binary file"),
        ("latin.csv", b"t,x,y,theta\n0,0,0,\xff\n", "line 2: not UTF-8"),
        ("not.npy", b"hello there, this is text", "beginning is damaged"),
        ("not.mat", b"hello there, this is text", "beginning is damaged"),
        ("run.pkl", pickle.dumps([1, 2, 3]), "pickle"),
        ("run.dat", pickle.dumps([1, 2, 3]), "pickle"),
    ],
)
def test_damage_is_named_with_file_and_place(tmp_path, name, content, reason):
    with pytest.raises(LogError, match=reason) as caught:
        read(write(tmp_path / name, content))
    assert name in str(caught.value)


def test_a_cut_off_npy_says_at_which_row(tmp_path):
    whole = npy_bytes(tmp_path, POSES)
    with pytest.raises(LogError, match="cut off at row 20 of 40"):
        read(write(tmp_path / "cut.npy", whole[: 128 + 20 * 96 + 5]), ReadOptions(dt=STEP))


def test_pickled_objects_are_refused_in_npy_and_npz(tmp_path):
    harmless = np.array([{"a": 1}, None], dtype=object)
    np.save(tmp_path / "run.npy", harmless, allow_pickle=True)
    np.savez(tmp_path / "run.npz", poses=harmless)
    for name in ("run.npy", "run.npz"):
        with pytest.raises(LogError, match="pickled objects"):
            read(tmp_path / name)


def test_a_header_that_promises_terabytes_costs_nothing(tmp_path):
    whole = npy_bytes(tmp_path, POSES)
    huge = whole.replace(b"(40, 3, 4)", b"(999999999999, 3, 4)"[:10].ljust(10))
    assert huge != whole
    huge = whole.replace(b"(40, 3, 4), }         ", b"(999999999, 3, 4), }  ")
    assert len(huge) == len(whole)
    with pytest.raises(LogError, match="cut off"):
        read(write(tmp_path / "huge.npy", huge), ReadOptions(dt=STEP))


def test_a_missing_file_and_a_folder(tmp_path):
    with pytest.raises(LogError, match="no such file"):
        read(tmp_path / "nothing.npy")
    with pytest.raises(LogError, match="a folder"):
        read(tmp_path)


def test_a_broken_description_beside_a_log(tmp_path):
    log_of(tmp_path / "run", 40).close()
    for text in ("{", "[1, 2]", "[" * 100_000):
        (tmp_path / "run.json").write_text(text)
        with pytest.raises(LogError, match=r"run\.json"):
            read(tmp_path / "run.npy")
    (tmp_path / "run.json").unlink()
    assert any("parameters unknown" in note for note in read(tmp_path / "run.npy").notes)


@given(st.data())
def test_any_flipped_byte_gives_a_named_error_or_a_recording(tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("flipped")
    small = POSES[:6]
    kind = data.draw(st.sampled_from(["npy", "npz", "mat", "csv"]))
    path = folder / f"run.{kind}"
    if kind == "npy":
        np.save(path, small)
    elif kind == "npz":
        np.savez(path, t=T[:6], poses=small)
    elif kind == "mat":
        savemat(path, {"t": T[:6], "poses": small})
    else:
        np.savetxt(path, np.column_stack([T[:6], small.reshape(6, -1)]), delimiter=",", fmt="%.4g")
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content)
    try:
        recording = read(path, ReadOptions(dt=STEP))
    except LogError as error:
        if "run." not in str(error):
            pytest.fail(f"the error does not name the file: {error}")
    else:
        assert np.isfinite(recording.poses).all()
        assert (np.diff(recording.t) > 0).all()


def test_unix_times_are_counted_from_the_first_pose(tmp_path):
    np.savez(tmp_path / "run.npz", t=T + 1.7e9, poses=POSES)
    recording = read(tmp_path / "run.npz")
    np.testing.assert_allclose(recording.t, T, atol=1e-6)
    assert any("1700000000" in note for note in recording.notes)


def test_json_of_a_log_is_found_from_its_name(tmp_path):
    log_of(tmp_path / "my.run", 30, seed=4).close()
    assert read(tmp_path / "my.run.npy").parameters["seed"] == 4
    assert json.loads((tmp_path / "my.run.json").read_text())["seed"] == 4


def test_known_flocks_are_recordings():
    assert known_flock("rotating", 0.1, duration=1.0).recording.robots == 10


def test_numbers_that_do_not_fit_are_refused_not_warned_about(tmp_path):
    wide = POSES.astype(np.longdouble)
    wide[3, 0, 0] = np.longdouble(10) ** 400
    np.save(tmp_path / "wide.npy", wide)
    with pytest.raises(LogError, match="row 3: x of robot 0 is inf"):
        read(tmp_path / "wide.npy", ReadOptions(dt=STEP))


def test_decimal_commas_between_semicolons(tmp_path):
    t, poses = rolling(20, 2)
    table = np.column_stack([t, poses.transpose(0, 2, 1).reshape(20, -1)])
    rows = [";".join(f"{value:.6f}".replace(".", ",") for value in row) for row in table]
    header = "t;x1;y1;theta1;x2;y2;theta2"
    for name, lines in (("named", [header, *rows]), ("bare", rows)):
        path = write(tmp_path / f"{name}.csv", "\n".join(lines))
        again = read(path, ReadOptions(columns=None if name == "named" else "robot"))
        np.testing.assert_allclose(again.poses, poses, rtol=0, atol=1e-6)
        np.testing.assert_allclose(again.t, t, rtol=0, atol=1e-6)
        assert any("decimal" in note for note in again.notes)


@pytest.mark.parametrize("name", ["time_ms", "t [ms]", "Time (ms)", "timestamp_ms"])
def test_milliseconds_are_told_by_the_columns_name(tmp_path, name):
    rows = "\n".join(f"{33 * k},{0.003 * k},0,0" for k in range(20))
    recording = read(write(tmp_path / "ms.csv", f"{name},x,y,theta\n{rows}"))
    np.testing.assert_allclose(recording.t, 0.033 * np.arange(20))
    assert any("milliseconds" in note for note in recording.notes)


def test_times_that_must_be_milliseconds_are_asked_about(tmp_path):
    rows = "\n".join(f"{33 * k},{0.003 * k},0,0" for k in range(20))
    with pytest.raises(LayoutError, match=r"33 s from one pose to the next.*milliseconds"):
        read(write(tmp_path / "ms.csv", f"t,x,y,theta\n{rows}"))


def test_times_that_are_not_finite_are_refused_by_row(tmp_path):
    t, poses = rolling(30, 2)
    t[4:6] = np.inf
    np.savez(tmp_path / "run.npz", poses=poses, t=t)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(LogError, match="row 4"):
            read(tmp_path / "run.npz", ReadOptions(layout="T,3,N"))


def track(told_by=Sign.SIGNATURE, **changes):
    """A form as a user might add it: poses of one robot under a line of its own."""

    def read_track(file, options):
        rows = np.loadtxt(file, skiprows=1)
        return Found(rows[:, 0], rows[:, 1:, np.newaxis], ("a track of one robot",))

    parts = {
        "name": "track",
        "label": "`.track`",
        "summary": "one robot: t, x, y, theta",
        "recognises": lambda file, start: start.startswith(b"TRACK"),
        "read": read_track,
        "endings": (".track",),
    }
    return Form(told_by=told_by, **parts | changes)


def test_a_new_form_is_one_entry_and_every_command_reads_it(tmp_path):
    t, poses = rolling(60, 1)
    file = tmp_path / "run.track"
    np.savetxt(file, np.column_stack([t, poses[:, :, 0]]), header="TRACK", comments="")
    words = ["report", str(file), "-o", str(tmp_path / "out"), "--json", "--radius", "1"]
    words.append("--no-figures")
    # Without the entry, its first line is a header of one column.
    assert CliRunner().invoke(app, words).exception is not None
    with registered(track()):
        done = CliRunner().invoke(app, words)
        assert done.exit_code == 0, done.output
        assert "a track of one robot" in json.loads(done.output)["how_it_was_read"]
        np.testing.assert_allclose(read(file).poses, poses)
        (tmp_path / "damaged.track").write_bytes(file.read_bytes()[1:])
        with pytest.raises(LogError, match=r"not a \.track file, or its beginning is damaged"):
            read(tmp_path / "damaged.track")
    assert "track" not in [form.name for form in known_forms()]


def test_the_surest_sign_wins_whoever_registered_first(tmp_path):
    np.save(tmp_path / "run.npy", POSES)
    anything = {"name": "mine", "recognises": lambda file, start: True}
    for told_by, wins in (
        (Sign.CONTENT, "mine"),
        (Sign.SIGNATURE, "npy"),
        (Sign.ENDING, "npy"),
        (Sign.NOTHING, "npy"),
    ):
        with registered(track(told_by, **anything)):
            assert form_of(tmp_path / "run.npy").name == wins
    log_of(tmp_path / "log", 40).close()
    assert form_of(tmp_path / "log.npy").name == "pose log"


def test_a_name_is_registered_once():
    with registered(track()), pytest.raises(ParameterError, match="registered already"):
        register(track())


def test_the_documentation_and_the_help_list_every_form():
    page = (Path(__file__).parents[1] / "docs" / "report.md").read_text(encoding="utf-8")
    help_text = CliRunner().invoke(app, ["report", "--help"], env={"COLUMNS": "200"}).output
    for form in known_forms():
        assert f"| {form.label} | {form.summary} |" in page
        if form.name not in ("pose log", "pickle"):  # "ours", and what is refused
            assert form.label.replace("`", "") in help_text
