"""Scripts that live by matplotlib's event loop run headless, in simulated time."""

import gc
import warnings

import matplotlib
import pytest

from rps_compat.run_settings import RunSettings
from rps_compat.runner import run_script
from rps_compat.testbed import MAX_DURATION

START = """
import threading, time
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=2, skip_initialization=True,
               initial_conditions=np.array([[-0.5, 0.5], [0, 0], [0, 0]]))
seen = []
def drive(*frame):
    r.get_poses()
    r.set_velocities([0, 1], np.zeros((2, 2)))
    r.step()
    seen.append(frame)
"""


@pytest.fixture
def run(tmp_path, capsys):
    def run(body):
        script = tmp_path / "s.py"
        script.write_text(START + body + "\nprint('seen', len(seen), round(time.monotonic(), 2))\n")
        result = run_script(script, (), RunSettings(headless=True, generation=2, timeout=60))
        out, err = capsys.readouterr()
        return result, out + err

    return run


# What the script does, and how many steps that makes; FuncAnimation calls once more to begin with.
ANIMATIONS = {
    "frames": ("a = FuncAnimation(r._fig, drive, 30, repeat=False); plt.show()", 31),
    "a list of frames": ("a = FuncAnimation(r._fig, drive, 'abc', repeat=False); plt.show()", 4),
    "a generator": (
        "def frames():\n    while len(seen) < 25:\n        yield 0\n"
        "a = FuncAnimation(r._fig, drive, frames, save_count=5, repeat=False); plt.show()",
        25,
    ),
    "another figure, with blit": (
        "figure, axes = plt.subplots()\n(line,) = axes.plot([], [])\n"
        "def update(k):\n    drive(k)\n    line.set_data(range(k), range(k))\n    return [line]\n"
        "a = FuncAnimation(figure, update, 30, init_func=lambda: [line], blit=True, repeat=False)\n"
        "plt.show()",
        30,
    ),
    "closed by itself": (
        "def update(k):\n    drive(k)\n    if k == 20:\n        plt.close(r._fig)\n"
        "a = FuncAnimation(r._fig, update, cache_frame_data=False); plt.show()",
        22,
    ),
    "saved": ("a = FuncAnimation(r._fig, drive, 5); a.save('a.gif', writer='pillow', dpi=20)", 6),
    "shown without waiting": (
        "a = FuncAnimation(r._fig, drive, 100, interval=50, repeat=False)\n"
        "plt.show(block=False); plt.pause(1.0)",
        21,
    ),
    "a timer": (
        "t = r._fig.canvas.new_timer(interval=40)\n"
        "t.add_callback(lambda: drive() or len(seen) < 10); t.start(); plt.show()",
        10,
    ),
    "a timer that ends the loop": (
        "t = r._fig.canvas.new_timer(interval=100)\n"
        "t.add_callback(lambda: drive() or len(seen) < 5 or r._fig.canvas.stop_event_loop())\n"
        "t.start(); r._fig.canvas.start_event_loop(60)",
        5,
    ),
    "a single shot": (
        "t = r._fig.canvas.new_timer(interval=100)\nt.single_shot = True\n"
        "t.add_callback(drive); t.start(); plt.pause(2)",
        1,
    ),
    "events in the script's own loop": (
        "t = r._fig.canvas.new_timer(interval=100); t.add_callback(drive); t.start()\n"
        "for k in range(20):\n    time.sleep(0.05); r._fig.canvas.flush_events()",
        15,  # the steps take time, too
    ),
    "another thread": (
        "def loop():\n    for k in range(50):\n        drive(k)\n"
        "threading.Thread(target=loop, daemon=True).start(); plt.show()",
        50,
    ),
}


@pytest.mark.parametrize("name", ANIMATIONS)
def test_steps_in_callbacks_are_made(run, name):
    body, steps = ANIMATIONS[name]
    result, said = run(body)
    assert result.exit_code == 0, said
    assert f"seen {steps} " in said
    assert result.reports[0].steps == steps


def test_a_script_that_does_not_wait_at_show_leaves_that_to_itself(run):
    run("plt.ion(); plt.rcParams['lines.linewidth'] = 9; plt.show()")
    result, _ = run("a = FuncAnimation(r._fig, drive, 30, repeat=False); plt.show()")
    assert result.reports[0].steps == 31
    assert matplotlib.rcParams["lines.linewidth"] != 9


def test_frames_come_at_their_interval(run):
    """A step takes 33 ms of the 50 ms between two frames; a frame that takes longer delays them."""
    _, said = run(
        "time.monotonic = (lambda now, start: lambda: now() - start)"
        "(time.monotonic, time.monotonic())\n"
        "a = FuncAnimation(r._fig, drive, 20, interval=50, repeat=False); plt.show()"
    )
    assert float(said.split()[-1]) == pytest.approx(20 * 0.05 + 0.033 + 0.05, abs=0.04)
    result, _ = run("a = FuncAnimation(r._fig, drive, 20, interval=1, repeat=False); plt.show()")
    assert result.reports[0].duration == pytest.approx(21 * 0.033)


def test_an_animation_that_would_repeat_plays_once_and_says_so(run):
    result, said = run("a = FuncAnimation(r._fig, drive, 12); plt.show()")
    assert "seen 13 " in said
    assert result.notes == ("an animation that would repeat for ever was played once",)


def test_what_nobody_closes_ends_with_the_longest_run(run):
    result, said = run(
        "a = FuncAnimation(r._fig, drive, interval=500, cache_frame_data=False); plt.show()"
    )
    assert result.exit_code == 0
    assert int(said.split("seen ")[1].split()[0]) == pytest.approx(MAX_DURATION / 0.5, abs=1)
    assert result.notes == ("plt.show() ended after 900 s, since nobody closes the window",)


@pytest.mark.parametrize(
    "body",
    [
        "r._fig.canvas.mpl_connect('key_press_event', drive); plt.show()",
        "plt.waitforbuttonpress(); plt.ginput(1, timeout=5); plt.show()",
        "a = FuncAnimation(r._fig, drive, 30, repeat=False); a.pause()",
        "pass",
    ],
)
def test_a_robotarium_that_never_steps_is_told(run, body):
    result, _ = run(body)
    with warnings.catch_warnings():  # matplotlib's, of what was never drawn
        warnings.simplefilter("ignore")
        gc.collect()
    assert (result.ended, result.exit_code) == ("idle", 4)
    assert "a Robotarium was made and never stepped" in result.reason
    assert not result.clean


def test_the_drive_to_the_start_is_no_step_of_the_script(tmp_path):
    script = tmp_path / "s.py"
    script.write_text(START.replace("skip_initialization=True", "skip_initialization=False"))
    result = run_script(script, (), RunSettings(headless=True, generation=2))
    assert result.reports[0].steps > 10
    assert result.ended == "idle"
    script.write_text(script.read_text() + "drive()")
    assert run_script(script, (), RunSettings(headless=True, generation=2)).ended == "finished"


def test_without_timers_a_window_costs_no_time(run):
    body = "plt.plot([0], [0]); plt.show(); plt.pause(0.5); plt.show(block=True); drive()"
    _, said = run(f"start = time.monotonic()\n{body}\nprint('took', time.monotonic() - start)")
    took = float(said.split("took ")[1].split()[0])
    assert took == pytest.approx(0.533, abs=2e-5)
