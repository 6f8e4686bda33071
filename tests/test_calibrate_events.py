"""Speed gain and delay from the times that a script prints, and nothing else."""

import json
import textwrap
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from posflock_robotarium.cli import app
from posflock_robotarium.event_calibration.times import fit_events
from posflock_robotarium.event_calibration.trials import (
    Candidate,
    Heard,
    hear,
    mean_of,
    script_source,
    with_candidate,
)
from posflock_robotarium.flocking.errors import LogError, ParameterError
from posflock_robotarium.logs.event_lines import events_in
from posflock_robotarium.verify.trials import Limits
from rps_compat.profiles import load_profile

#: Two robots drive to and fro between marks, and say when they pass them.
SHUTTLE = textwrap.dedent("""
    import numpy as np
    import rps.robotarium as robotarium

    start = np.array([[-1.2, -1.2], [-0.3, 0.3], [0.0, 0.0]])
    r = robotarium.Robotarium(number_of_robots=2, show_figure=False, initial_conditions=start)
    marks, speeds, passed = (-1.0, -0.7, -0.4, -0.1), (0.14, 0.1), [0, 0]
    for k in range(460):
        x = r.get_poses()
        for i in range(2):
            if passed[i] < len(marks) and x[0, i] > marks[passed[i]]:
                print(f"[t={k * 0.033:5.1f}s] robot {'AB'[i]} at mark {x[0, i]:.2f}")
                passed[i] += 1
        if k % 200 == 50:
            print(f"[t={k * 0.033:5.1f}s] still here")
        going = [speeds[i] * (passed[i] < len(marks)) for i in range(2)]
        r.set_velocities(np.arange(2), np.array([going, [0.0, 0.0]]))
        r.step()
    r.call_at_scripts_end()
""")


def run(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


@pytest.mark.parametrize(
    ("line", "event"),
    [
        ("[t= 50.3s] marshal at gate 2", ("marshal at gate", 50.3)),
        ("t=7.25 lap -3.5e-2 of 4", ("lap of", 7.25)),
        ("Time: 12 s, robot 3 arrived", (", robot arrived", 12.0)),
        ("12.5 s: robot 3 arrived", (": robot arrived", 12.5)),
        ("robot 3 arrived at 12.5 seconds", ("robot arrived", 12.5)),
        ("[INFO] [1781808957.765] [robotarium]: Starting Experiment", None),
        ("wrote 12 rows", None),
    ],
)
def test_events_are_lines_with_a_time_without_their_numbers(line, event):
    expected = {} if event is None else {(event[0], 0): event[1]}
    assert events_in(line) == expected


def test_a_line_that_comes_again_is_another_event():
    text = "[t=1.0s] lap 1\nno time\n[t=2.0s] lap 2\n"
    assert events_in(text) == {("lap", 0): 1.0, ("lap", 1): 2.0}


def arrivals(candidate, ways=(2.0, 5.0, 9.0, 14.0), noise=0.2):
    """Robots of a known kind: ways in m at 0.14 m/s, a late start at every one of them."""
    rng = np.random.default_rng(candidate.seed)
    late = np.cumsum(rng.normal(0, noise, len(ways)))
    times = np.array(ways) / 0.14 / candidate.gain + 4 * candidate.delay + late
    events = {(f"at {way}", 0): float(time) for way, time in zip(ways, times, strict=True)}
    return Heard(candidate, events | {("on the clock", 0): 30.0}, 200.0)


def simulated(candidates):
    return [arrivals(candidate) for candidate in candidates]


def test_intervals_hold_the_truth_and_say_what_is_not_known():
    held = []
    for seed in range(40):
        truth = Candidate(0.6 + 0.01 * seed, 0.2, 1000 + seed)
        fit = fit_events(arrivals(truth).events, simulated, 16, 0.2, seed=50 * seed)
        assert fit.gain.value == pytest.approx(truth.gain, rel=0.05)
        assert fit.scheduled == 1
        assert fit.delay is None or fit.delay.low <= truth.delay <= fit.delay.high
        held.append(fit.gain.low <= truth.gain <= fit.gain.high)
    assert np.mean(held) >= 0.95


def test_events_that_do_not_hang_on_speed_determine_nothing():
    with pytest.raises(LogError, match="hangs on how fast"):
        fit_events({("on the clock", 0): 30.0}, simulated, 16, 0.2)
    with pytest.raises(LogError, match="none of the log's 1 timed lines"):
        fit_events({("other script", 0): 30.0}, simulated, 16, 0.2)


def test_a_profile_keeps_everything_but_gain_and_delay():
    base = load_profile("gritsbot_x")
    slow = with_candidate(base, Candidate(0.7, 0.3, 0))
    assert mean_of(slow.gains.speed) == pytest.approx(0.7)
    assert slow.gains.by_speed == base.gains.by_speed
    assert slow.dead_time.by_speed == base.dead_time.by_speed
    assert replace(slow, gains=base.gains, dead_time=base.dead_time) == base


@pytest.mark.slow  # a hundred trials
def test_the_command_finds_the_gain_that_made_a_log(tmp_path):
    script, log, out = (tmp_path / name for name in ("shuttle.py", "printed.txt", "lab.toml"))
    script.write_text(SHUTTLE)
    truth = Candidate(0.8, 0.2, 77)
    (made,) = hear(script_source(script), load_profile("gritsbot_x"), [truth], Limits())
    log.write_text("".join(f"[t={at:5.1f}s] {name}\n" for (name, _), at in made.events.items()))
    words = ("calibrate", "--events", log, "--script", script, "-n", 8, "-o", out)
    done = run(*words, "--json")
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    low, high = found["gain"]["low"], found["gain"]["high"]
    assert low <= truth.gain <= high
    assert high - low < 0.15
    assert found["scheduled"] == 3
    profile = load_profile(out)
    assert mean_of(profile.gains.speed) == pytest.approx(found["gain"]["value"])
    assert "timed lines of printed.txt" in profile.about


@pytest.mark.parametrize(
    "words", [(), ("a.npz", "--events", "b.txt", "--script", "c.py"), ("--events", "b.txt")]
)
def test_either_poses_or_events_with_their_script(words):
    done = run("calibrate", *words)
    assert isinstance(done.exception, ParameterError)
    assert "--events with --script" in str(done.exception)
