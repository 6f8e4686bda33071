"""γ by three estimators of motion, and the share of robots that each of them leaves out."""

from __future__ import annotations

import numpy as np

from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.measured_run import CurveFunction, Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import Metric, NumberFunction, Scalar, register
from posflock_robotarium.alignment.panels import ALIGNMENT, LEFT_OUT
from posflock_robotarium.alignment.reductions import settled_mean
from posflock_robotarium.freespace.neighbour_search import TREE_FROM_AGENTS

FEWEST_COUNTED = 0.005
"""Share of robots and time that a mean γ must rest on, lest noise speak for a parked flock."""


def alignment_of(run: MeasuredRun, estimator: str) -> metrics.Alignment:
    """Return γ over time by one estimator; ask for it by ``run.once(alignment_of, estimator)``.

    Parameters
    ----------
    run : MeasuredRun
        The run, with its neighbour radius and its least speed.
    estimator : str
        How the direction of motion is found, a key of `estimators.ESTIMATORS`.

    Returns
    -------
    Alignment
        γ and the number of robots that it is taken over, (T,) arrays.
    """
    velocities, samples = run.velocities(estimator), len(run.recording.t)
    gamma, counted = np.empty(samples), np.empty(samples, dtype=int)
    for stretch in run.stretches():
        found = metrics.alignment(
            velocities[stretch],
            run.positions[stretch],
            run.radius,
            slowest=least_speed(run, estimator),
            heard=run.neighbours(stretch) if run.robots < TREE_FROM_AGENTS else None,
        )
        gamma[stretch], counted[stretch] = found.gamma, found.counted
    return metrics.Alignment(gamma, counted)


def least_speed(run: MeasuredRun, estimator: str) -> float:
    """Return the speed in m/s up to which a robot has no direction; a heading it always has.

    Parameters
    ----------
    run : MeasuredRun
        The run, whose options hold the speed, m/s.
    estimator : str
        How the direction of motion is found, a key of `estimators.ESTIMATORS`.
    """
    return 0.0 if estimator == "headings" else run.options.slowest


def _gamma(estimator: str) -> CurveFunction:
    return lambda run: run.once(alignment_of, estimator).gamma if run.has_neighbours else None


def _left_out(estimator: str) -> CurveFunction:
    def left_out(run: MeasuredRun) -> Floats | None:
        if not run.has_neighbours:
            return None
        counted = run.once(alignment_of, estimator).counted
        if run.all_seen:
            return np.asarray(1.0 - counted / run.recording.robots)
        # Who is not seen is no robot that γ leaves out.
        seen = run.seen.sum(axis=1)
        share: Floats = np.divide(counted, seen, out=np.full(len(seen), np.nan), where=seen > 0)
        return 1.0 - share

    return left_out


def _mean_gamma(short: str) -> NumberFunction:
    of_gamma, of_left_out = settled_mean(f"gamma_{short}"), settled_mean(f"left_out_{short}")

    def mean(run: MeasuredRun) -> float | None:
        left_out = of_left_out(run)
        if left_out is None:
            return None
        return of_gamma(run) if left_out <= 1.0 - FEWEST_COUNTED else float("nan")

    return mean


def _gamma_number(short: str, words: str, column: str = "") -> Scalar:
    return Scalar(
        f"gamma_{short}",
        f"γ from {words}",
        "",
        "Mean over time {run.since}, where defined; undefined when less than "
        f"{FEWEST_COUNTED:.1%} of robots and time can be counted.",
        "Alignment",
        _mean_gamma(short),
        latex=True,
        column=column,
    )


def _left_out_number(short: str, words: str, latex: bool = False) -> Scalar:
    return Scalar(
        f"left_out_{short}",
        f"left out of γ from {words}",
        "share",
        "Mean share of robots that γ does not count {run.since}.",
        "Alignment",
        settled_mean(f"left_out_{short}"),
        latex=latex,
    )


register(
    Metric(
        "gamma_motion",
        "γ from motion",
        "",
        "The same with directions of motion, estimated by a Savitzky-Golay derivative. "
        "Where robots go.",
        _gamma("savitzky_golay"),
        panel=ALIGNMENT,
        figure="alignment",
        legend="motion",
        beside_replay=True,
        band=("gamma_motion_low", "gamma_motion_high"),
        numbers=(_gamma_number("motion", "motion (Savitzky-Golay)", "γ motion"),),
    ),
    Metric(
        "left_out_motion",
        "left out, motion",
        "",
        "Share of robots that γ from motion does not count: too slow to have a direction, or "
        "without a neighbour that moves.",
        _left_out("savitzky_golay"),
        panel=LEFT_OUT,
        figure="alignment",
        legend="motion",
        numbers=(_left_out_number("motion", "motion (Savitzky-Golay)", latex=True),),
    ),
    Metric(
        "gamma_headings",
        "γ from headings",
        "",
        "Mean over robots of the mean cosine between a robot's heading and its neighbours'. "
        "Where robots point: parked robots have headings too.",
        _gamma("headings"),
        panel=ALIGNMENT,
        figure="alignment",
        legend="headings",
        beside_replay=True,
        band=("gamma_headings_low", "gamma_headings_high"),
        numbers=(_gamma_number("headings", "headings", "γ headings"),),
    ),
    Metric(
        "left_out_headings",
        "left out, headings",
        "",
        "Share of robots that γ from headings does not count, having no neighbour.",
        _left_out("headings"),
        "largest",
        panel=LEFT_OUT,
        figure="alignment",
        legend="headings",
        numbers=(_left_out_number("headings", "headings"),),
    ),
    Metric(
        "gamma_differences",
        "γ from raw differences",
        "",
        "The same with one-frame differences of position. Biased downwards by tracking noise; "
        "shown for comparison only.",
        _gamma("differences"),
        panel=ALIGNMENT,
        figure="alignment",
        legend="raw differences",
        band=("gamma_differences_low", "gamma_differences_high"),
        numbers=(_gamma_number("differences", "raw differences"),),
    ),
    Metric(
        "left_out_differences",
        "left out, raw differences",
        "",
        "Share of robots that γ from raw differences does not count.",
        _left_out("differences"),
        numbers=(_left_out_number("differences", "raw differences"),),
    ),
)
