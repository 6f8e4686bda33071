"""Scripts that start processes with robots in them, and how they are run."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

COMMON = """
import numpy as np
from rps.robotarium import Robotarium

def drive(steps, apart=0.5, speed=0.1, crash=None):
    start = np.array([[-apart, apart], [0, 0], [0, 0]])
    r = Robotarium(number_of_robots=2, show_figure=False, sim_in_real_time=False,
                   skip_initialization=True, initial_conditions=start)
    for k in range(steps):
        r.get_poses()
        r.set_velocities(np.arange(2), np.array([[speed, speed], [0, 0]]))
        r.step()
        if k == crash:
            1 / 0
    return r
"""


def run(folder, text, *options, arguments=(), **files):
    """Run a script beside `common.py` by `posflock run`.

    Temporary files are made in a folder of its own, so that a test can see what is `left` there;
    its path is short, since those of sockets must be.
    Return the ended process, the report, and what this tells of each process.
    """
    home = folder / "home"
    home.mkdir(exist_ok=True)
    for name, content in {"common": COMMON, "script": text, **files}.items():
        (home / f"{name}.py").write_text(content)
    command = [Path(sys.executable).with_name("posflock"), "run", "--headless", "--generation", "2"]
    command += ["-o", folder / "out", *options, home / "script.py", *arguments]
    with tempfile.TemporaryDirectory() as temporary:
        done = subprocess.run(
            command, cwd=home, env=os.environ | {"TMPDIR": temporary}, capture_output=True,
            text=True, check=False,
        )  # fmt: skip
        left = [path.name for path in Path(temporary).rglob("*")]
    data = json.loads((folder / "out" / "report.json").read_text()) | {"left": left}
    return done, data, {r["process"]: r for r in data["reports"]}


def notes_on_children(data):
    """The notes of a run without those on its time."""
    return [n for n in data["notes"] if "in real time" not in n and "ends every run" not in n]
