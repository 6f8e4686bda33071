"""What the testbed printed beside a log: the drive, what stopped the run, timed lines."""

import zipfile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from posflock_robotarium.alignment.options import AnalysisOptions
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.logs.event_lines import events_in
from posflock_robotarium.logs.printed_log import printed_log_of, read_printed
from posflock_robotarium.logs.readers import read
from posflock_robotarium.logs.start import experiment_start
from posflock_robotarium.report import Run, analyse

BEGAN = 1_780_000_100.5
STAMPED = f"""a library's warning: something is missing
[INFO] [{BEGAN - 49.5:.6f}] [robotarium]: Initializing 2 robots to initial conditions...
[INFO] [{BEGAN - 0.5:.6f}] [robotarium]: At initial conditions... Starting Experiment
[INFO] [{BEGAN:.6f}] [robotarium]: Starting Experiment
My run: 2 robots, 60 s
[t= 12.5s] halfway at 3 m
[t= 20.0s] both arrived
"""
COLLISION = "Collision Detected! \n Stopping experiment!\n"
INTERRUPT = """Traceback (most recent call last):
  File "/user_data/main.py", line 7, in <module>
[t= 21.0s] a buffered line
    r.step()
KeyboardInterrupt
"""
FAILED = """Traceback (most recent call last):
  File "/user_data/main.py", line 7, in <module>
    1 / 0
ZeroDivisionError: division by zero
"""
T = 0.033 * np.arange(900)


def poses():
    x = 0.05 * T[:, None] + np.array([-0.5, -0.5])
    y = np.broadcast_to([0.0, 0.4], x.shape)
    return np.stack([x, y, np.zeros_like(x)], axis=1)


def whole(folder, printed, t=T, name="log.txt", **known):
    """Return the verdict on the end of a run beside which this was printed."""
    np.savez(folder / "run.npz", t=t, poses=poses(), **known)
    (folder / name).write_text(printed)
    analysis = analyse(folder / "run.npz", radius=0.75)
    found = [v for v in analysis.verdicts if v.question == "Is it the whole run?"]
    return analysis, (found[0] if found else None)


def test_stamps_events_and_ends_are_read():
    found = printed_log_of(STAMPED, "log.txt")
    assert found.drive == pytest.approx(49.0)
    assert (found.robots, found.began_at) == (2, BEGAN)
    assert (found.events, found.last_time) == (2, 20.0)
    assert (found.collision, found.interrupted, found.error) == (False, False, "")
    assert printed_log_of(STAMPED + COLLISION, "log.txt").collision
    stopped = printed_log_of(STAMPED + INTERRUPT, "log.txt")
    assert (stopped.interrupted, stopped.error, stopped.last_time) == (True, "", 21.0)
    assert printed_log_of(STAMPED + FAILED, "x").error == "ZeroDivisionError: division by zero"


def test_a_script_that_talks_of_collisions_has_had_none():
    assert not printed_log_of("[t= 1.0s] Collision Detected! avoided\n", "log.txt").collision
    assert printed_log_of("t,x,y\n0,1,2\n", "log.txt") is None


def test_of_endless_printing_the_first_and_the_last_lines_count():
    text = STAMPED + "\n" * 300_000 + COLLISION
    found = printed_log_of(text, "log.txt")
    assert found.robots == 2
    assert found.collision


@given(st.text())
def test_any_text_is_read_or_tells_nothing(text):
    found = printed_log_of(text, "log.txt")
    assert found is None or found.told


@pytest.mark.parametrize(
    ("printed", "answer"),
    [
        (STAMPED, "Yes, the script ended by itself."),
        (STAMPED + COLLISION, "No: a collision stopped it."),
        (STAMPED + INTERRUPT, "No: a KeyboardInterrupt ended it."),
        (STAMPED + FAILED, "No: an error ended the script."),
        (STAMPED + "[t= 45.0s] done\n", "No: lines were printed after its last pose."),
        ("[t= 5.0s] hello\n", "Nothing says how it ended."),
    ],
)
def test_what_was_printed_tells_whether_it_is_the_whole_run(tmp_path, printed, answer):
    assert whole(tmp_path, printed)[1].answer == answer


def test_a_collision_that_the_testbed_saw_is_not_called_safe(tmp_path):
    analysis, verdict = whole(tmp_path, STAMPED + COLLISION, name="run_log.txt")
    safe = next(v for v in analysis.verdicts if v.question == "Was it safe?")
    assert (safe.mark, safe.answer) == ("bad", "No: the testbed detected a collision.")
    assert "None is seen in the poses." in verdict.because
    assert analysis.numbers["drive_time"].value == pytest.approx(49.0)
    assert "in run_log.txt: the drive to the start took 49.0 s" in analysis.recording.notes[-1]


def test_what_is_of_another_run_is_not_used_and_named(tmp_path):
    analysis, verdict = whole(tmp_path, STAMPED.replace("2 robots to", "9 robots to"))
    assert verdict is None
    assert "it tells of 9 robots, the log holds 2" in analysis.recording.notes[-1]
    analysis, verdict = whole(tmp_path, STAMPED, t=BEGAN + 86400 + T)
    assert verdict is None
    assert "of a run 1440 minutes away" in analysis.recording.notes[-1]


def test_the_drive_within_a_log_is_left_out_of_what_is_settled(tmp_path):
    analysis, _ = whole(tmp_path, STAMPED, t=BEGAN - 8.0 + T)
    assert analysis.start == pytest.approx(8.0, abs=1e-4)
    assert analysis.numbers["drive_in_log"].value == pytest.approx(8.0, abs=1e-4)
    assert analysis.settled.sum() == (analysis.recording.t > 28.0).sum()
    assert analysis.numbers["time_to_alignment_headings"].value < 0.04
    assert "after the drive to the start" in analysis.numbers["gamma_motion"].definition


def test_the_user_or_the_log_may_say_how_long_the_drive_is():
    run = Run("run", T, poses(), parameters={"drive": 3.0})
    assert experiment_start(run) == 3.0
    assert experiment_start(run, 5.0) == 5.0
    assert experiment_start(Run("run", T, poses(), parameters={"drive": "far"})) == 0.0
    late = analyse(run, AnalysisOptions(radius=0.75, transient=2.0, drive=10.0))
    assert late.settled.sum() == (T > 12.0).sum()
    with pytest.raises(
        ParameterError, match=r"--drive is 30 s; expected from 0 to below the 29.67"
    ):
        analyse(run, AnalysisOptions(radius=0.75, drive=30.0))
    with pytest.raises(ParameterError, match="drive is -1"):
        AnalysisOptions(drive=-1.0)


def test_a_folder_or_zip_of_one_run_may_hold_it(tmp_path):
    whole(tmp_path, STAMPED + INTERRUPT)
    assert read(tmp_path).printed.interrupted
    with zipfile.ZipFile(tmp_path.parent / "run.zip", "w") as archive:
        for name in ("run.npz", "log.txt"):
            archive.write(tmp_path / name, f"results/{name}")
    assert read(tmp_path.parent / "run.zip").printed.interrupted


def test_a_saved_analysis_keeps_it(tmp_path):
    analysis, _ = whole(tmp_path, STAMPED, t=BEGAN - 8.0 + T)
    from posflock_robotarium.report import load

    again = load(analysis.save(tmp_path / "a.npz"))
    assert again.recording.printed == analysis.recording.printed
    assert again.start == analysis.start


def test_what_cannot_be_read_tells_nothing(tmp_path):
    assert read_printed(tmp_path / "none.txt") is None
    assert read_printed(tmp_path) is None


def test_events_are_found_as_for_a_calibration():
    assert events_in(STAMPED)["both arrived", 0] == 20.0
