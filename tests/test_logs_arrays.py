"""Arrays of poses, of numpy or MATLAB, are read alike in whatever layout scripts leave them."""

import h5py
import numpy as np
import pytest
from rolling_robots import POSES, STEP, T, flat, rolling
from scipy.io import loadmat, savemat

from posflock_robotarium.logs.readers.layouts import sideways_share, to_states
from posflock_robotarium.logs.readers.matlab5 import read_matlab5
from posflock_robotarium.logs.readers.matlab_trees import by_dotted_name
from posflock_robotarium.report import LayoutError, ReadOptions, read


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
    poses, _, how = to_states(square, "square")
    assert poses.shape == (24, 3, 8)
    assert "sideways" in how


def test_a_shape_that_nothing_decides_is_asked_for():
    still = np.zeros((12, 12)) + np.arange(12)
    with pytest.raises(LayoutError, match=r"say which with --layout"):
        to_states(still, "still")
    assert to_states(still, "still", "T,3N", "robot")[0].shape == (12, 3, 4)


def test_more_robots_than_a_testbed_holds_need_the_layout_by_name():
    many = np.zeros((70, 3, 60))
    with pytest.raises(LayoutError, match=r"name one with --layout"):
        to_states(many, "many")
    assert to_states(many, "many", "T,3,N")[0].shape == (70, 3, 60)


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
    ours = by_dotted_name(read_matlab5(tmp_path / "run.mat"))
    theirs = loadmat(tmp_path / "run.mat")
    assert set(ours) == {"cube", "row", "one", "nothing"}
    for name, array in ours.items():
        np.testing.assert_array_equal(array, theirs[name])


def test_a_count_that_three_divides_is_no_evidence_for_poses(tmp_path):
    positions = POSES[:, :2, :3].transpose(0, 2, 1).reshape(len(T), 6)  # of three robots
    np.save(tmp_path / "run.npy", positions)
    with pytest.raises(LayoutError, match=r"sideways|say which with --layout"):
        read(tmp_path / "run.npy", ReadOptions(dt=STEP))
    np.save(tmp_path / "one.npy", POSES[:, [2, 0, 1], 0])
    with pytest.raises(LayoutError, match=r"sideways.*--layout T,3N"):
        read(tmp_path / "one.npy", ReadOptions(dt=STEP))
    assert read(tmp_path / "one.npy", ReadOptions(dt=STEP, layout="T,3N")).robots == 1


def test_time_and_three_robots_are_not_two_robots_with_commands(tmp_path):
    t, poses = rolling(200, 3)
    table = poses.transpose(0, 2, 1).reshape(len(t), 9)
    np.save(tmp_path / "run.npy", np.column_stack([t, table]))
    run = read(tmp_path / "run.npy")
    np.testing.assert_array_equal(run.poses, poses)
    np.testing.assert_array_equal(run.t, t)
