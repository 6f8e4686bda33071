"""With a display there is a window, animated in real time and resizable, as people know it."""

import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

pytestmark = pytest.mark.skipif(shutil.which("Xvfb") is None, reason="needs Xvfb")

SCRIPT = """
import time
import numpy as np
from PIL import ImageGrab
from rps.robotarium import *

N = 4
r = Robotarium(number_of_robots=N, show_figure=True, sim_in_real_time=True,
               initial_conditions=np.array([[-0.9, -0.3, 0.3, 0.9], [0, 0, 0, 0], [0, 0, 0, 0.0]]))
assert r.figure.canvas.manager is not None
r.axes.text(0, 0.8, "drawn by the script")
start = time.perf_counter()
for k in range(45):
    if k == 5:
        r.figure.canvas.manager.resize(900, 620)
    x = r.get_poses()
    r.set_velocities(np.arange(N), np.array([[0.1] * N, [0.3] * N]))
    r.step()
print("seconds", time.perf_counter() - start)
r.figure.canvas.draw(); r.figure.canvas.flush_events()
ImageGrab.grab().save("screen.png")
print("width", r.figure.get_size_inches()[0] * r.figure.dpi)
r.call_at_scripts_end()
"""


@pytest.fixture
def display():
    reading, writing = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(writing), "-screen", "0", "1280x800x24", "-nolisten", "tcp"],
        pass_fds=[writing],
        stderr=subprocess.DEVNULL,
    )
    os.close(writing)
    with os.fdopen(reading) as answer:
        number = answer.readline().strip()
    yield f":{number}"
    server.terminate()
    server.wait()


def test_window_is_animated_in_real_time(display, tmp_path):
    pytest.importorskip("tkinter")
    (tmp_path / "script.py").write_text(SCRIPT)
    environment = {k: v for k, v in os.environ.items() if k != "MPLBACKEND"}
    ran = subprocess.run(
        [sys.executable, "-m", "rps_compat", "run", "--window", "script.py"],
        cwd=tmp_path,
        env={**environment, "DISPLAY": display},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert ran.returncode == 0, ran.stderr
    said = dict(line.split(maxsplit=1) for line in ran.stdout.splitlines()[:2])
    assert float(said["seconds"]) >= 45 * 0.033 - 0.05, "a step waits for its slot"
    assert float(said["width"]) == pytest.approx(900, abs=20), "the figure follows its window"

    from matplotlib.image import imread

    screen = imread(tmp_path / "screen.png")[..., :3]
    yellow = (np.abs(screen - np.array([0.91, 0.77, 0.28])) < 0.05).all(axis=2)
    assert yellow.sum() > 400, "four robots are on the screen"
    columns = np.flatnonzero(yellow.any(axis=0))
    assert np.ptp(columns) > 400, "all over the window"


def test_a_window_that_is_asked_for_without_a_display_is_no_obstacle(tmp_path):
    (tmp_path / "script.py").write_text(
        SCRIPT.replace("from PIL import ImageGrab", "")
        .replace('ImageGrab.grab().save("screen.png")', "")
        .replace("r.figure.canvas.manager.resize", "len")
        .replace("(900, 620)", "([1])")
    )
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    ran = subprocess.run(
        [sys.executable, "-m", "rps_compat", "run", "script.py"],
        cwd=tmp_path,
        env={**environment, "MPLBACKEND": "TkAgg"},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert ran.returncode == 0, ran.stderr
