"""What MATLAB scripts leave: the testbed's own table, structures, cells, old and new versions."""

import h5py
import numpy as np
import pytest
from rolling_robots import POSES, STEP, T, rolling
from scipy.io import savemat

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers import LogClock
from posflock_robotarium.report import LayoutError, ReadOptions, read

MATLAB = POSES.transpose(1, 2, 0)
ROBOTS = np.empty((1, 4), dtype=object)
STEPS = np.empty((1, len(T)), dtype=object)
for n in range(4):
    x, y, theta = POSES[:, :, n].T
    ROBOTS[0, n] = {"x": x[None], "y": y[None], "theta": theta[None]}
for k in range(len(T)):
    STEPS[0, k] = {"poses": POSES[k], "t": T[k]}


def with_commands(robots, samples=240):
    """(5N, T): x, y, heading, v and ω of each robot."""
    _, poses = rolling(samples, robots)
    commands = np.full((samples, 2, robots), 0.1)
    commands[:, 1] = np.linspace(-0.3, 0.3, robots)
    states = np.concatenate([poses, commands], axis=1)
    return poses, commands, states.transpose(2, 1, 0).reshape(5 * robots, samples)


@pytest.mark.parametrize(
    ("name", "robots"), [("robotarium_data", 3), ("robotarium_data", 9), ("anything", 9)]
)
def test_rows_that_three_divides_are_robots_of_five_numbers(tmp_path, name, robots):
    poses, commands, table = with_commands(robots)
    savemat(tmp_path / "run.mat", {name: table})
    run = read(tmp_path / "run.mat", ReadOptions(dt=STEP))
    np.testing.assert_array_equal(run.poses, poses)
    np.testing.assert_array_equal(run.commands, commands)
    assert any("five numbers a robot" in note for note in run.notes)


def test_where_two_readings_fit_both_are_named_with_the_option(tmp_path):
    savemat(tmp_path / "run.mat", {"table": np.tile(np.linspace(-1, 1, 45)[:, None], 260)})
    with pytest.raises(LayoutError, match=r"15 robots.*9 robots.*--layout 3N,T or --layout 5N,T"):
        read(tmp_path / "run.mat", ReadOptions(dt=STEP))
    asked = read(tmp_path / "run.mat", ReadOptions(dt=STEP, layout="5N,T", columns="robot"))
    assert asked.robots == 9


@pytest.mark.parametrize(
    ("variables", "array"),
    [
        ({"data": {"t": T, "poses": MATLAB}}, "data.poses"),
        ({"run": {"log": {"t": T, "anything": MATLAB}}}, "run.log.anything"),
        ({"log": {"time": T, "robots": ROBOTS}}, "log.robots.x"),
        ({"steps": STEPS}, "steps.poses"),
    ],
)
def test_structures_and_cells_have_dotted_names(tmp_path, variables, array):
    savemat(tmp_path / "run.mat", variables)
    run = read(tmp_path / "run.mat")
    np.testing.assert_allclose(run.poses, POSES)
    np.testing.assert_allclose(run.t, T)
    assert any(array in note for note in run.notes)


def test_one_of_several_is_chosen_by_its_dotted_name(tmp_path):
    savemat(tmp_path / "run.mat", {"t": T, "a": {"q": MATLAB}, "b": {"q": MATLAB + 0.5}})
    with pytest.raises(LayoutError, match=r"a\.q.*b\.q.*--array"):
        read(tmp_path / "run.mat")
    run = read(tmp_path / "run.mat", ReadOptions(array="b.q"))
    np.testing.assert_allclose(run.poses, POSES + 0.5)


def test_groups_and_cells_of_version_7_3(tmp_path):
    with h5py.File(tmp_path / "run.mat", "w", userblock_size=512) as file:
        file["data/t"] = T[:, np.newaxis]
        cells = [file.create_dataset(f"#refs#/{k}", data=POSES[k].T) for k in range(len(T))]
        references = np.array([[cell.ref] for cell in cells], dtype=h5py.ref_dtype)
        file.create_dataset("data/poses", data=references, dtype=h5py.ref_dtype)
    run = read(tmp_path / "run.mat")
    np.testing.assert_array_equal(run.poses, POSES)
    np.testing.assert_array_equal(run.t, T)


def test_version_4(tmp_path):
    savemat(tmp_path / "run.mat", {"t": T, "poses": POSES.reshape(len(T), -1)}, format="4")
    run = read(tmp_path / "run.mat")
    np.testing.assert_array_equal(run.poses, POSES)
    assert "MATLAB 4" in run.notes[0]
    (tmp_path / "cut.mat").write_bytes((tmp_path / "run.mat").read_bytes()[:-9])
    with pytest.raises(LogError, match="cut off"):
        read(tmp_path / "cut.mat")


def test_objects_are_refused_with_how_to_export_them(tmp_path):
    with h5py.File(tmp_path / "run.mat", "w", userblock_size=512) as file:
        file["log"] = np.zeros((1, 6), dtype=np.uint32)
        file["log"].attrs["MATLAB_object_decode"] = 3
    with pytest.raises(LogError, match=r"log: MATLAB objects .*writetable\(log"):
        read(tmp_path / "run.mat")


def test_poses_and_commands_by_shape_and_a_useless_time(tmp_path):
    _, poses = rolling(60, 3)
    inputs = np.full((2, 3, 60), 0.1)
    times = np.abs(np.random.default_rng(0).normal(1e-5, 1e-5, 60))
    file = tmp_path / "run.mat"
    savemat(
        file,
        {"input_data": inputs, "pose_data": poses.transpose(1, 2, 0), "time": times},
    )
    with pytest.raises(LayoutError, match=r"its times are none.*--dt"):
        read(file)
    run = read(file, ReadOptions(dt=STEP))
    np.testing.assert_array_equal(run.poses, poses)
    np.testing.assert_array_equal(run.commands, inputs.transpose(2, 0, 1))
    np.testing.assert_allclose(run.t, STEP * np.arange(60))
    assert any("times not used" in note for note in run.notes)


def test_times_are_passed_over_as_asked(tmp_path):
    np.savez(tmp_path / "run.npz", t=2 * T, poses=POSES)
    run = read(tmp_path / "run.npz", ReadOptions(dt=STEP, clock=LogClock.NONE))
    np.testing.assert_allclose(run.t, T)
