"""Logs that were cut off, have gaps, or lie in several files are read for what they hold."""

import json

import numpy as np
import pytest
from rolling_robots import POSES, STEP, T, log_of

from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.report import ReadOptions, Run, read, read_parts


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
    unseen = np.argwhere(~read(tmp_path / "run.npz").seen)
    np.testing.assert_array_equal(unseen, [[row, 2] for row in range(10, 20)])
    recording = read(tmp_path / "run.npz", ReadOptions(drop_damaged=True))
    assert recording.gaps.tolist() == [10]
    assert len(recording.t) == 30


def test_a_broken_description_beside_a_log(tmp_path):
    log_of(tmp_path / "run", 40).close()
    for text in ("{", "[1, 2]", "[" * 100_000):
        (tmp_path / "run.json").write_text(text)
        with pytest.raises(LogError, match=r"run\.json"):
            read(tmp_path / "run.npy")
    (tmp_path / "run.json").unlink()
    assert any("parameters unknown" in note for note in read(tmp_path / "run.npy").notes)


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
