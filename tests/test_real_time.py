"""The two clocks of a run: steps that were counted, and the real time that passed."""

import json
import time

import numpy as np
import pytest

from posflock_robotarium.calibration.resimulate import read_commanded
from posflock_robotarium.calibration.step_times import TimesOrigin, step_times_of
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.flocking.pose_log import PoseLog, row_type
from posflock_robotarium.logs.convert import convert
from posflock_robotarium.logs.readers import LogClock, ReadOptions, read
from posflock_robotarium.logs.real_time import believed, clock_of, on_a_grid

STEP, ROWS = 0.033, 200
T = STEP * np.arange(ROWS)


def real_steps(seed=0):
    """Step times as loops of hardware have them, with one stall of 0.8 s."""
    steps = STEP + 0.002 * np.abs(np.random.default_rng(seed).standard_normal(ROWS - 1))
    steps[50] = 0.8
    return steps


REAL = 40.0 + np.concatenate([[0.0], np.cumsum(real_steps())])


def write(path, real_time=REAL, **metadata):
    told = {"neighbour_radius": 0.75, "simulated": None, "opened_at": 1.78e9, **metadata}
    with PoseLog(path, 2, ROWS, told, real_time=False) as log:
        for k, t in enumerate(T):
            poses = [[0.1 * t, 0.1 * t], [0.0, 0.4], [0.0, 0.0]]
            at = None if real_time is None else float(real_time[k])
            log.append(t, poses, [[0.1, 0.1], [0.0, 0.0]], real_time=at)
    return log.path


def test_a_row_is_written_with_the_real_time_since_the_log_was_opened(tmp_path):
    with PoseLog(tmp_path / "run", 1, 3) as log:
        for k in range(3):
            time.sleep(0.02)
            log.append(0.033 * k, np.zeros((3, 1)), np.zeros((2, 1)))
    rows = np.load(tmp_path / "run.npy")
    assert (np.diff(rows["real_time"], prepend=0.0) >= 0.02).all()
    opened = json.loads((tmp_path / "run.json").read_text())["opened_at"]
    assert abs(time.time() - opened) < 600


def test_in_simulation_there_is_none(tmp_path):
    path = write(tmp_path / "run", None)
    assert np.isnan(np.load(path)["real_time"]).all()
    assert read(path).real_time is None


def test_a_log_of_an_earlier_format_is_read_without(tmp_path):
    fields = [name for name in row_type(2).names if name != "real_time"]
    rows = np.zeros(ROWS, row_type(2))[fields].astype([(n, row_type(2)[n]) for n in fields])
    rows["t"] = T
    np.save(tmp_path / "old.npy", rows)
    run = read(tmp_path / "old.npy")
    assert run.real_time is None
    assert run.notes[0] == "pose log, 200 of 200 rows reached"


def test_time_real_puts_the_clock_in_the_place_of_the_steps(tmp_path):
    path = write(tmp_path / "run")
    run, over = read(path), read(path, ReadOptions(clock=LogClock.REAL))
    assert np.array_equal(run.t, T)
    assert np.array_equal(run.real_time, REAL)
    assert np.allclose(over.t, REAL - REAL[0])
    assert "the clock of the log" in over.notes[-1]
    with pytest.raises(LogError, match="no real time in it"):
        read(write(tmp_path / "simulated", None), ReadOptions(clock=LogClock.REAL))


@pytest.mark.parametrize("ending", ["npz", "mat", "npy"])
def test_converted_logs_carry_it_along(tmp_path, ending):
    run = read(write(tmp_path / "run"))
    again = read(convert(run, tmp_path / f"again.{ending}"))
    assert np.array_equal(again.real_time, REAL)
    assert again.parameters["opened_at"] == 1.78e9


@pytest.mark.parametrize(
    ("real_time", "said"),
    [
        (np.where(np.arange(ROWS) == 7, 0.0, REAL), "in row 7 it does not go forward"),
        (np.where(np.arange(ROWS) == 9, np.nan, REAL), "in row 9 it does not go forward"),
        (T / 1000, "as in a simulation"),
        (np.zeros(ROWS), "in row 1 it does not go forward"),
    ],
)
def test_a_clock_that_cannot_be_the_robots_is_not_used_and_named(tmp_path, real_time, said):
    run = read(write(tmp_path / "run", real_time))
    assert run.real_time is None
    assert said in run.notes[-1]


def test_what_says_that_it_was_simulated_has_no_real_time():
    assert believed(REAL, T, simulated=True) == (None, "")


def test_steps_are_counted_or_measured():
    assert on_a_grid(np.array([0.033, 0.033, 0.066]))
    assert not on_a_grid(real_steps())


def test_the_clock_of_a_run(tmp_path):
    run = read(write(tmp_path / "run"))
    assert np.array_equal(clock_of(run), REAL)
    assert clock_of(read(write(tmp_path / "counted", None))) is None
    np.savez(tmp_path / "recorded.npz", t=REAL, poses=run.poses)
    assert clock_of(read(tmp_path / "recorded.npz")) is not None


def test_calibration_takes_real_steps_where_the_log_has_them(tmp_path):
    path = write(tmp_path / "run")
    times = step_times_of(read(path))
    assert times.origin is TimesOrigin.RECORDED
    assert times.steps.max() == pytest.approx(0.8)
    assert np.allclose(read_commanded(path).t, REAL - REAL[0])
