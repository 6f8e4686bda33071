"""Filming nine robots, as GIF and as MP4, against drawing the same frames in plain matplotlib.

What is judged is CPU time for a frame, the encoder's included. The reference draws the same arena,
bodies and trails at the same size by `Figure.canvas.draw`, moving artists that are made once, and
takes the pixels; it encodes nothing.
"""

from __future__ import annotations

import sys
import tempfile
from functools import partial
from pathlib import Path

import numpy as np
from comparing import Table, Times, cpu, cpu_with_children

from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.flocking.errors import OutputError
from posflock_robotarium.logs.readers import Run
from posflock_robotarium.report.video import RATE, SIZE, TRAIL, find_ffmpeg, write_video

DURATION, FRAMES = 40.0, 60
#: Most of the reference's time.
MOST = {"gif": 1.0, "mp4": 1.0}


def filmed(recording: Run, path: Path) -> float:
    """Return the CPU seconds of a frame of film."""
    frames = DURATION * RATE[path.suffix]
    return cpu_with_children(lambda: write_video(recording, path)) / frames


def drawn(recording: Run, kind: str) -> float:
    """Return the CPU seconds of a frame in plain matplotlib."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Circle

    width, height = SIZE[f".{kind}"]
    figure = Figure(figsize=(width / 100, height / 100), dpi=100)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.01, 0.01, 0.98, 0.92))
    axes.set(xlim=(-1.65, 1.65), ylim=(-1.05, 1.05), aspect="equal")
    axes.set_axis_off()
    axes.plot([-1.6, 1.6, 1.6, -1.6, -1.6], [-1, -1, 1, 1, -1], "k")
    trails = [axes.plot([], [], "0.6")[0] for _ in range(recording.robots)]
    bodies = [axes.add_patch(Circle((0, 0), 0.055)) for _ in range(recording.robots)]
    noses = [axes.plot([], [], "k")[0] for _ in range(recording.robots)]
    clock = figure.text(0.015, 0.955, "")
    length = round(TRAIL / recording.step)

    def frames() -> None:
        for row in np.linspace(length, len(recording.t) - 1, FRAMES).astype(int):
            x, y, heading = recording.poses[row]
            past = recording.poses[row - length : row : 5]
            for robot in range(recording.robots):
                trails[robot].set_data(past[:, 0, robot], past[:, 1, robot])
                bodies[robot].center = x[robot], y[robot]
                tip = 0.055 * np.cos(heading[robot]), 0.055 * np.sin(heading[robot])
                noses[robot].set_data([x[robot], x[robot] + tip[0]], [y[robot], y[robot] + tip[1]])
            clock.set_text(f"{recording.t[row]:6.1f} s")
            canvas.draw()
            np.asarray(canvas.buffer_rgba())

    return cpu(frames) / FRAMES


def main() -> int:
    """Measure, print, and return 1 where a requirement is missed."""
    # Ten robots: known flocks are even, and one more is no advantage.
    recording = known_flock("rotating", 0.1, robots=10, duration=DURATION).recording
    kinds = ["gif"]
    try:
        find_ffmpeg()
        kinds.append("mp4")
    except OutputError as error:
        print(error)
    table = Table()
    with tempfile.TemporaryDirectory() as folder:
        for kind in kinds:
            film = partial(filmed, recording, Path(folder) / f"run.{kind}")
            times = Times({"film": film, "plain": partial(drawn, recording, kind)}, rounds=3)
            what = f"a frame of {kind}, against plain matplotlib"
            table.ratio(what, times, "film", "plain", MOST[kind])
    return table.exit_code()


if __name__ == "__main__":
    sys.exit(main())
