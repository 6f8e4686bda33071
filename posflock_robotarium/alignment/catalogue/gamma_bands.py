"""Between which values γ of the same run would lie without noise, at every time.

A band needs noise that can be measured, and that is of every frame's own. Where a log is too short
to measure it, or its poses look filtered or interpolated, there is no band; the verdict says so.
"""

from __future__ import annotations

import math

import numpy as np

from posflock_robotarium.alignment.catalogue.confidence import noise_of
from posflock_robotarium.alignment.catalogue.gamma import alignment_of, least_speed
from posflock_robotarium.alignment.estimators import PERSISTENT
from posflock_robotarium.alignment.gamma_band import (
    LARGEST_ERROR,
    Band,
    gamma_band,
    of_headings,
    of_motion,
)
from posflock_robotarium.alignment.measured_run import CurveFunction, Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import Metric, Scalar, register
from posflock_robotarium.alignment.velocity_noise import noise_persistence, velocity_gain

NEGLIGIBLE = 5e-5
"""Metres of noise that move γ by 1e-5 at 0.05 m/s, however they are carried over."""

MOSTLY = 0.5
"""Share of the samples with a γ that must have a band, lest those that chance favours speak."""

_WORDS = {
    "motion": ("savitzky_golay", "γ from motion"),
    "headings": ("headings", "γ from headings"),
    "differences": ("differences", "γ from raw differences"),
}


def persistence_of(run: MeasuredRun) -> float | None:
    """Return `estimators.noise_persistence`; None where noise is negligible or nothing is known.

    Parameters
    ----------
    run : MeasuredRun
        The run; ask by ``run.once(persistence_of)``.
    """
    noise = run.once(noise_of).position
    if not noise > NEGLIGIBLE:
        return None
    persistence = noise_persistence(run.recording)
    return None if math.isnan(persistence) else persistence


def band_of(run: MeasuredRun, short: str) -> Band | None:
    """Return the band of γ by one estimator; None where it cannot be known.

    Parameters
    ----------
    run : MeasuredRun
        The run; ask by ``run.once(band_of, short)``.
    short : {'motion', 'headings', 'differences'}
        The estimator, as the keys of the curves have it.
    """
    noise, persistence = run.once(noise_of), run.once(persistence_of)
    if math.isnan(noise.position) or (persistence is not None and persistence > PERSISTENT):
        return None
    estimator, _ = _WORDS[short]
    if estimator == "headings":
        if not (run.recording.headed and math.isfinite(noise.heading)):
            return None
        directions = of_headings(run.velocities(estimator), noise.heading)
    else:
        gain = velocity_gain(run.recording, estimator, run.options.window)
        directions = of_motion(
            run.velocities(estimator), noise.position * gain, least_speed(run, estimator)
        )
    if np.nanmean(directions.variance > LARGEST_ERROR**2) > MOSTLY:  # noise hides most of them
        return None
    band = gamma_band(
        directions, run.positions, run.radius, noise.position, run.stretches(), run.neighbours
    )
    defined = np.isfinite(run.once(alignment_of, estimator).gamma)
    known = np.isfinite(band.low) & defined
    return band if known.sum() > MOSTLY * defined.sum() else None


def _end(short: str, end: str) -> CurveFunction:
    def curve(run: MeasuredRun) -> Floats | None:
        band: Band | None = run.once(band_of, short)
        return None if band is None else band.low if end == "low" else band.high

    return curve


def _width(run: MeasuredRun) -> float | None:
    band: Band | None = run.once(band_of, "motion")
    return None if band is None else run.settled_mean(band.high - band.low)


register(
    *(
        Metric(
            f"gamma_{short}_{end}",
            f"{words}, 95 % band, {end} end",
            "",
            f"{end.capitalize()} end of the band in which {words} of the same run would lie "
            "without tracking noise, with 95 % at every time; undefined where noise hides the "
            "direction of a robot that counts.",
            _end(short, end),
        )
        for short, (_, words) in _WORDS.items()
        for end in ("low", "high")
    ),
    Scalar(
        "gamma_band",
        "95 % band of γ from motion, width",
        "",
        "Mean {run.since} of how broad the band is in which γ without tracking noise lies.",
        "Confidence",
        _width,
        latex=True,
    ),
    Scalar(
        "noise_persistence",
        "noise of every third frame over that of neighbours",
        "",
        "1 where each frame has a noise of its own; larger where poses were filtered or "
        f"interpolated. Beyond {PERSISTENT:g} no band is given; not judged below "
        f"{1e6 * NEGLIGIBLE:g} µm.",
        "Confidence",
        lambda run: run.once(persistence_of),
    ),
)
