"""How often the band of γ holds the truth: flocks seen with noise, and the same ones without.

What a band has to hold is what the same estimator reads of the same run without noise. So each
flock is recorded twice, and coverage is the share of the samples at which the γ of the clean
recording lies within the band of the noisy one. Five flocks span what γ can be:

============ ===================================================== =========
flock        what the robots do                                    γ about
============ ===================================================== =========
parallel     straight on, all in one direction                     1
close        wander, each about 4° off the common course           0.99
loose        wander, each about 25° off it                         0.6 to 0.9
scattered    wander, each in a direction of its own                0
counter      circle together, every other one backwards            -1/(N-1)
============ ===================================================== =========
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.measured_run import MeasuredRun
from posflock_robotarium.alignment.measuring import measure
from posflock_robotarium.alignment.options import AnalysisOptions
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.logs.run import Run
from rps_compat.testbed import TIME_STEP

Floats = NDArray[np.float64]

FLOCKS = {"parallel": 0.0, "close": 0.07, "loose": 0.45, "scattered": 3.0, "counter": 0.0}
"""Each flock, and how far robots are off the common course, rad (standard deviation)."""

ESTIMATORS = ("motion", "headings", "differences")
RADIUS = dict.fromkeys(FLOCKS, 0.75) | {"counter": 100.0}
"""Neighbour radius, m. Of robots that go opposite ways all are neighbours."""

_SEEN = 1e-9
"""What rounding may take from γ."""


def clean_flock(
    flock: str, robots: int, speed: float, *, duration: float = 60.0, seed: int = 0
) -> Run:
    """Return a flock as nobody sees it: without noise.

    Parameters
    ----------
    flock : str
        A key of `FLOCKS`.
    robots : int
        How many.
    speed : float
        Of the robots on average, m/s; each has one of its own within a quarter of it.
    duration : float
        Seconds.
    seed : int
        Of places, speeds and courses.

    Raises
    ------
    ParameterError
        For an unknown flock.
    """
    if flock not in FLOCKS:
        raise ParameterError(f"flock {flock!r} is none of {', '.join(FLOCKS)}")
    rng = np.random.default_rng(seed)
    t: Floats = TIME_STEP * np.arange(round(duration / TIME_STEP), dtype=float)
    # All but the first circle together, so that they stay near each other.
    turning = 0.0 if flock == "parallel" else 0.5
    course = np.repeat((0.7 + turning * t)[:, np.newaxis], robots, axis=1)
    if flock == "counter":
        course += np.pi * (np.arange(robots) % 2)
    elif FLOCKS[flock]:
        off = FLOCKS[flock] * rng.standard_normal(robots)
        period, phase = rng.uniform(8.0, 20.0, robots), rng.uniform(0.0, 2 * np.pi, robots)
        sway = np.sin(2 * np.pi * t[:, np.newaxis] / period + phase)
        course += off + 0.5 * min(FLOCKS[flock], 0.5) * sway
    speeds = speed * rng.uniform(0.75, 1.25, robots)
    velocity = speeds * np.stack([np.cos(course), np.sin(course)], axis=1)
    start = rng.uniform(-0.8, 0.8, (2, robots))
    positions = start + TIME_STEP * np.cumsum(velocity, axis=0)
    return Run(
        f"{flock}",
        t,
        np.concatenate([positions, course[:, np.newaxis]], axis=1),
        parameters={"neighbour_radius": RADIUS[flock]},
    )


def noisy(run: Run, position_noise: float, heading_noise: float, *, seed: int = 0) -> Run:
    """Return what a tracking system sees of a run.

    Parameters
    ----------
    run : Run
        Without noise.
    position_noise, heading_noise : float
        Standard deviations, m and rad.
    seed : int
        Of the noise.
    """
    rng = np.random.default_rng(seed)
    poses = run.poses.copy()
    poses[:, :2] += position_noise * rng.standard_normal(poses[:, :2].shape)
    poses[:, 2] += heading_noise * rng.standard_normal(poses[:, 2].shape)
    return replace(run, poses=poses)


@dataclass(frozen=True)
class BandCoverage:
    """How often bands held the truth.

    Attributes
    ----------
    held : float
        Share of the samples with a band in which it held; NaN where there was none.
    known : float
        Share of the samples that have a band.
    width : float
        Mean width of the bands.
    gamma : float
        Mean of the truth.
    """

    held: float
    known: float
    width: float
    gamma: float


def coverage(
    clean: Run, position_noise: float, heading_noise: float, *, repeats: int = 6, seed: int = 0
) -> dict[str, BandCoverage]:
    """Return the coverage of each estimator's band for one flock.

    Parameters
    ----------
    clean : Run
        The flock without noise.
    position_noise, heading_noise : float
        Standard deviations, m and rad.
    repeats : int
        How often it is seen with another noise.
    seed : int
        Of the noise.
    """
    options = AnalysisOptions(transient=0.0)
    truth = measure(clean, options)
    seen = [
        measure(noisy(clean, position_noise, heading_noise, seed=seed + k), options)
        for k in range(repeats)
    ]
    return {estimator: _coverage(truth, seen, f"gamma_{estimator}") for estimator in ESTIMATORS}


def _coverage(truth: MeasuredRun, seen: list[MeasuredRun], key: str) -> BandCoverage:
    gamma = truth.curve(key)
    assert gamma is not None
    held, width, samples = [], [], 0
    for run in seen:
        low, high = run.curve(f"{key}_low"), run.curve(f"{key}_high")
        samples += len(gamma)
        if low is None or high is None:
            continue
        known = np.isfinite(low) & np.isfinite(gamma)
        within = (gamma >= low - _SEEN) & (gamma <= high + _SEEN)
        held.append(within[known])
        width.append((high - low)[known])
    together = np.concatenate(held) if held else np.empty(0)
    if not together.size:
        nan = float("nan")
        return BandCoverage(nan, 0.0, nan, float(np.nanmean(gamma)))
    return BandCoverage(
        float(together.mean()),
        together.size / samples,
        float(np.concatenate(width).mean()),
        float(np.nanmean(gamma)),
    )
