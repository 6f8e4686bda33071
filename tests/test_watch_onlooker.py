"""Who looks on holds the script in its step, and what they change holds from that step on."""

import json
import os

import numpy as np
import pytest

from barrier_certificates.hearing import heard_by
from posflock_robotarium.flocking.attendance import attended_by
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.logs.recorder import open_pose_log
from posflock_robotarium.watch.onlooker import Lines, WatchedRun
from posflock_robotarium.watch.requests import Pause, Retune, Speed, Step, Stop, UseProfile
from posflock_robotarium.watch.settings import Settings
from rps_compat.profiles import load_profile
from rps_compat.running.driver import Guests, drive
from rps_compat.running.plan import ClockPolicy, RunPlan

STRAIGHT = """
import numpy as np
from rps.robotarium import Robotarium
r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.3, 0], [0, 0.0]]))
for k in range(40):
    r.get_poses()
    r.set_velocities(np.arange(2), np.full((2, 2), 0.1))
    r.step()
"""
FLOCK = """
import numpy as np
from rps.robotarium import Robotarium
from posflock_robotarium.flocking.flock import Flock
start = np.array([[-0.3, 0.3, 0.0], [0.0, 0.0, 0.4], [0.0, 1.0, 2.0]])
flock = Flock()
r = Robotarium(number_of_robots=3, initial_conditions=start)
for k in range(20):
    r.set_velocities(np.arange(3), flock.step(r.get_poses()).command)
    r.step()
print("radius", flock.law.radius, flock.model, len(flock.retuned))
"""
THREADED = """
import threading, time
import numpy as np
from rps.robotarium import Robotarium
ticks = []
def tick():
    for _ in range(3):
        time.sleep(0.1)
        ticks.append(time.monotonic())
threading.Thread(target=tick).start()
r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0, 0], [0, 0.0]]))
for k in range(20):
    r.get_poses()
    r.step()
print("ticks", *np.round(np.diff(ticks), 3))
"""

FAST = Settings(speed=None)


@pytest.fixture
def watched(tmp_path):
    """Run a script in this process with requests that wait for it; return what it told."""

    def run(source, requests=(), settings=FAST, generation=2, late=None, initial="exact"):
        script = tmp_path / "script.py"
        script.write_text(source)
        out, into = os.pipe()
        os.write(into, "".join(request.text() + "\n" for request in requests).encode())
        told = []

        def tell(kind, text):
            told.append((kind, json.loads(text)))
            if late is not None:
                late(into, told)

        profiles = {name: load_profile(name) for name in ("ideal", "harsh")}
        run = WatchedRun(tell, Lines(out), settings, profiles, seed=1)

        def opened(*about):
            run.logs.append(open_pose_log(*about))
            return run.logs[-1]

        plan = RunPlan(
            script=str(script), folder=str(tmp_path), generation=generation, initial=initial,
            seed=1, script_seed=1, clock=ClockPolicy.SIMULATED, draws_on_demand=True,
            out=str(tmp_path / "out"),
        )  # fmt: skip
        with heard_by(run.heard), attended_by(run.attend):
            outcome = drive(plan, Guests(recorder=opened, onlookers=(run,)))
        os.close(into)
        os.close(out)
        return outcome, told, run

    return run


def of_kind(told, kind):
    return [data for what, data in told if what == kind]


def test_a_run_that_nobody_asks_anything_shows_itself_and_ends(watched):
    outcome, told, _ = watched(STRAIGHT)
    assert outcome.ended == "finished"
    (scene,) = of_kind(told, "scene")
    assert scene["robots"] == 2
    first = of_kind(told, "frame")[0]
    assert first["step"] == 0
    assert first["poses"][0] == [-0.5, 0.5]
    assert first["commands"] == [[0.1, 0.1], [0.1, 0.1]]
    assert first["barrier"] is None
    assert "links" not in first  # nobody tells who is whose neighbour
    assert of_kind(told, "state")[-1]["flock"] is None


@pytest.mark.parametrize("generation", [1, 2])
def test_pictures_say_while_robots_are_driven_to_their_start(watched, generation):
    _, told, run = watched(STRAIGHT, generation=generation, initial="drive")
    run.show(last=True)
    frames = of_kind(told, "frame")
    steps = run._arena.steps_to_start
    assert frames[0]["driving_to_start"]
    assert {f["driving_to_start"] for f in frames if f["step"] < steps} == {True}
    assert {f["driving_to_start"] for f in frames if f["step"] >= steps} == {False}


def test_a_held_run_drives_as_many_steps_as_are_asked_for(watched):
    outcome, told, _ = watched(STRAIGHT, [Pause(), Step(3)], late=stop_when_held_at(3))
    assert outcome.ended == "interrupted"
    assert outcome.steps == 3
    assert [frame["step"] for frame in of_kind(told, "frame")] == [0, 3]
    assert of_kind(told, "state")[-1]["settings"]["paused"]


def stop_when_held_at(step):
    def late(into, told):
        if told[-1][0] == "frame" and told[-1][1]["step"] == step:
            os.write(into, (Stop().text() + "\n").encode())

    return late


def test_nobody_left_who_watches_ends_the_run(watched):
    def late(into, told):
        if told[-1][0] == "frame":
            os.dup2(os.open(os.devnull, os.O_WRONLY), into)

    outcome, _, _ = watched(STRAIGHT, [Pause()], late=late)
    assert outcome.ended == "interrupted"


@pytest.mark.parametrize("generation", [1, 2])
def test_a_profile_holds_from_its_step_on_and_is_kept_in_the_log(watched, generation, tmp_path):
    requests = [UseProfile("harsh")]
    before = watched(STRAIGHT, generation=generation)[2]._arena
    _, told, run = watched(STRAIGHT, requests, generation=generation)
    assert of_kind(told, "state")[-1]["settings"]["profile"] == "harsh"
    # Motors that answer late: nobody has moved as far as in the ideal arena.
    assert np.all(np.abs(run._arena.poses[2]) < np.abs(before.poses[2]))
    described = json.loads((tmp_path / "out" / "poses.json").read_text())
    assert described["changed_while_watched"] == [{"time": 0.0, "profile": "harsh"}]


def test_the_live_poses_of_generation_one_stay_true_to_what_is_tracked(watched):
    """Noise of the tracking must not reach the true poses, nor outlive the profile."""
    script = STRAIGHT.replace("    r.get_poses()\n", "    seen = r.get_poses()\n")
    script += "assert np.shares_memory(r.poses, r._arena.poses) == IDEAL, r.poses\n"
    harsh, ideal = UseProfile("harsh"), UseProfile("ideal")
    assert watched(script.replace("IDEAL", "False"), [harsh], generation=1)[0].exit_code == 0
    assert watched(script.replace("IDEAL", "True"), [harsh, ideal], generation=1)[0].exit_code == 0


def test_a_flock_follows_what_is_asked_from_its_next_step_on(watched, capsys):
    requests = [Retune(radius=1.5), Retune(model=Model.VELOCITY, persistence=0.4)]
    outcome, told, _ = watched(FLOCK, requests)
    assert outcome.ended == "finished"
    assert "radius 1.5 velocity 2" in capsys.readouterr().out
    law = of_kind(told, "state")[-1]["flock"]
    assert (law["radius"], law["persistence"], law["model"]) == (1.5, 0.4, "velocity")
    assert law["distance_scale"] == 0.12
    frame = of_kind(told, "frame")[-1]
    assert frame["barrier"]["clearance"] > 0.0
    assert -1.0 <= frame["gamma"]["headings"] <= 1.0


def test_a_hold_is_no_time_for_threads_of_the_script(watched, capsys):
    """A thread that sleeps beside the loop wakes at its own simulated times, hold or not."""
    slow = Settings(speed=0.25)

    def late(into, told):
        steps = sum(kind == "frame" for kind, _ in told)
        if steps == 4 and told[-1][0] == "frame":
            os.write(into, (Speed(None).text() + "\n").encode())

    outcome, _, _ = watched(THREADED, settings=slow, late=late)
    assert outcome.ended == "finished"
    assert not [note for note in outcome.notes if "in real time" in note]
    assert "ticks 0.1 0.1" in capsys.readouterr().out
