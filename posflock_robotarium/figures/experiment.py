"""The paper's experiment figures, from a pose log: snapshots, alignment, distances, speeds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.alignment import catalogue
from posflock_robotarium.alignment.measured_run import MeasuredRun
from posflock_robotarium.alignment.measuring import measure
from posflock_robotarium.alignment.metrics import SMOOTHING_POINTS
from posflock_robotarium.alignment.options import AnalysisOptions
from posflock_robotarium.figures.look import OF_ESTIMATOR, shade
from posflock_robotarium.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    in_style,
    new_figure,
    save,
)
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.flocking.flock import told_walls
from posflock_robotarium.logs.run import Run
from rps_compat.testbed import ROBOT_LENGTH, ROBOT_WIDTH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Seconds of trail behind each robot in a snapshot.
TRAIL = 12.0


def draw_run(log: Run, folder: Path) -> list[Path]:
    """Draw every figure of a run, each as PNG and PDF; return the paths.

    Parameters
    ----------
    log : Run
        Poses over time, with neighbour radius and arena.
    folder : Path
        Where the files are put.

    Raises
    ------
    LogError
        Where the log is too short to draw.
    OutputError
        Where the folder cannot be written.
    """
    if len(log.t) < SMOOTHING_POINTS:
        raise LogError(f"the log holds {len(log.t)} rows; at least {SMOOTHING_POINTS} are needed")
    drawn = {
        "snapshots": snapshots(log),
        "alignment": alignment_over_time(log),
        "distances": distances_and_speeds(log),
    }
    return [path for name, figure in drawn.items() for path in save(figure, folder, name)]


@in_style
def snapshots(log: Run, times: Sequence[float] | None = None) -> Figure:
    """Draw the arena at six instants: robots to scale, headings, trails (paper, Fig. 7).

    Parameters
    ----------
    log : Run
        Poses over time, with their arena.
    times : six floats, optional
        Seconds; evenly spread over the run by default.
    """
    figure = new_figure(7.2, 3.55)
    panels = figure.subplots(2, 3, sharex=True, sharey=True)
    chosen = np.linspace(log.t[0], log.t[-1], 6) if times is None else np.asarray(times)
    for axes, time, letter in zip(panels.flat, chosen, "abcdef", strict=True):
        row = ties.first_smallest(np.abs(log.t - time))
        _arena(axes, log)
        recent = (log.t <= log.t[row]) & ties.reached(log.t, log.t[row] - TRAIL)
        axes.plot(log.poses[recent, 0], log.poses[recent, 1], color=GREY, linewidth=0.7, zorder=1)
        for n, pose in enumerate(log.poses[row].T):
            if np.isfinite(pose).all():
                _robot(axes, pose)
            else:
                _last_seen(axes, log.poses[: row + 1, :, n])
        axes.set_title(f"({letter})  t = {log.t[row]:.0f} s", fontsize=8, pad=3)
    for axes in panels[-1]:
        axes.set_xlabel("x (m)")
    for axes in panels[:, 0]:
        axes.set_ylabel("y (m)")
    _say_walls(figure, log)
    return figure


@in_style
def alignment_over_time(log: Run, radius: float | None = None) -> Figure:
    """Draw γ over time, from headings and from motion (paper, Fig. 8).

    Parameters
    ----------
    log : Run
        Poses over time.
    radius : float, optional
        Neighbour radius, m; by default what the log says.
    """
    figure = new_figure(3.5, 2.4)
    axes = figure.subplots()
    run, low = measure(log, AnalysisOptions(radius=radius)), 0.0
    for estimator in ("motion", "headings"):  # the dashes above
        look, key = OF_ESTIMATOR[estimator], f"gamma_{estimator}"
        gamma, metric = run.curve(key), catalogue.metrics()[key]
        if gamma is None:
            continue
        low_end, high_end = (run.curve(end) for end in metric.band or ())
        if low_end is not None and high_end is not None:
            shade(axes, log.t, low_end, high_end, look)
        axes.plot(
            log.t,
            gamma,
            color=look.colour,
            linestyle=look.dash,
            linewidth=look.width,
            label=metric.legend,
        )
        low = min(low, float(np.nanmin(gamma, initial=0.0)))
    axes.set(
        xlabel="time (s)", ylabel="alignment γ (–)", xlim=(0, log.t[-1]), ylim=(low - 0.05, 1.05)
    )
    axes.axhline(1.0, color=GREY, linewidth=0.5, zorder=0)
    axes.legend(loc="lower right", title="γ from", title_fontsize=7)
    _say_walls(figure, log)
    return figure


@in_style
def distances_and_speeds(log: Run) -> Figure:
    """Draw nearest-neighbour, smallest and wall distances, cohesive radius, and speeds.

    Parameters
    ----------
    log : Run
        Poses over time, with their arena.
    """
    figure = new_figure(7.2, 2.4)
    left, right = figure.subplots(1, 2)
    run = measure(log)
    _distances(left, run)
    _speeds(right, run)
    _say_walls(figure, log)
    return figure


def _distances(axes: Axes, run: MeasuredRun) -> None:
    t, known, top = run.recording.t, catalogue.metrics(), 0.0
    for key, colour, dash in (
        ("cohesive_radius", BLACK, (0, (1, 1))),
        ("nearest_neighbour", BLUE, "-"),
        ("smallest_distance", ORANGE, (0, (4, 1.5))),
        ("wall_distance", GREEN, (0, (5, 1, 1, 1))),
    ):
        values, metric = run.curve(key), known[key]
        if values is not None:
            label = metric.legend or metric.label
            axes.plot(t, values, color=colour, linestyle=dash, linewidth=1.1, label=label)
            top = max(top, float(np.nanmax(values, initial=0.0)))
    collision = run.robot.collision_diameter
    axes.axhline(collision, color=GREY, linewidth=0.8)
    axes.text(
        t[-1],
        collision - 0.01,
        f"collision diameter {collision:g} m",
        fontsize=6,
        color="#555555",
        ha="right",
        va="top",
    )
    axes.set(xlabel="time (s)", ylabel="distance (m)", xlim=(0, t[-1]), ylim=(0, 1.32 * top))
    axes.legend(loc="upper right", ncols=2)


def _speeds(axes: Axes, run: MeasuredRun) -> None:
    t, speeds = run.recording.t, run.speeds
    axes.fill_between(
        t,
        np.fmin.reduce(speeds, axis=1),
        np.fmax.reduce(speeds, axis=1),
        color=BLUE,
        alpha=0.2,
        linewidth=0,
        label="slowest to fastest",
    )
    for key, colour, dash in (("speed", BLUE, "-"), ("drift", BLACK, (0, (4, 1.5)))):
        values, label = run.curve(key), catalogue.metrics()[key].legend
        if values is not None:
            axes.plot(t, values, color=colour, linestyle=dash, linewidth=1.1, label=label)
    axes.set(xlabel="time (s)", ylabel="speed (m/s)", xlim=(0, t[-1]))
    axes.set_ylim(0, 1.25 * float(np.nanmax(speeds)))
    axes.legend(loc="upper right", ncols=3)


def _say_walls(figure: Figure, log: Run) -> None:
    """Say above a figure what kept the flock off the walls and apart, where the log tells."""
    words = told_walls(log.parameters)
    if words:
        if log.parameters.get("wheels", {}).get("pair_rows") is False:
            words += "; control run: nobody is kept apart"
        figure.suptitle(f"walls: {words}", fontsize=6, color="#555555", x=0.995, ha="right")


def _arena(axes: Axes, log: Run) -> None:
    left, right, bottom, top = log.robot.boundaries
    axes.plot(
        [left, right, right, left, left],
        [bottom, bottom, top, top, bottom],
        color=BLACK,
        linewidth=1.0,
        zorder=0,
    )
    axes.set(xlim=(left - 0.06, right + 0.06), ylim=(bottom - 0.06, top + 0.06))
    axes.set_aspect("equal")
    axes.set_xticks([-1.5, 0, 1.5])
    axes.set_yticks([-1, 0, 1])
    for spine in axes.spines.values():
        spine.set_visible(False)


def _last_seen(axes: Axes, poses: NDArray[np.float64]) -> None:
    """Mark where a robot (T, 3) was last that is not seen, or whose heading is not known."""
    seen = np.flatnonzero(np.isfinite(poses[:, 0]))
    if seen.size:
        x, y = poses[seen[-1], :2]
        axes.plot(x, y, "x", color="#555555", markersize=4, markeredgewidth=0.8, zorder=2)


def _robot(axes: Axes, pose: NDArray[np.float64]) -> None:
    """Draw one robot to scale, an arrowhead inside telling its heading."""
    from matplotlib.patches import Polygon

    half_length, half_width = ROBOT_LENGTH / 2.0, ROBOT_WIDTH / 2.0
    body = np.array([[-1, 1, 1, -1], [-1, -1, 1, 1]]) * [[half_length], [half_width]]
    arrow = np.array([[0.9, -0.7, -0.35, -0.7], [0, 0.75, 0, -0.75]]) * [
        [half_length],
        [half_width],
    ]
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    turn = np.array([[cosine, -sine], [sine, cosine]])
    place = pose[:2, None]
    axes.add_patch(
        Polygon((turn @ body + place).T, facecolor=BLUE, edgecolor=BLACK, linewidth=0.4, zorder=2)
    )
    axes.add_patch(Polygon((turn @ arrow + place).T, facecolor="white", linewidth=0, zorder=3))
