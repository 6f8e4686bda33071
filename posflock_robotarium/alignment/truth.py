r"""Flocks whose γ is known exactly, seen through a tracking system that jitters.

An estimator is only as good as its error against truth. Five motions with closed-form γ are
sampled at the testbed's rate and given its noise; `errors` then says how far each estimator is off.

========== ==================================================== ==============================
motion     what the robots do                                   true γ
========== ==================================================== ==============================
parallel   straight on, all in one direction                    1
counter    straight on, every other one backwards               :math:`-1/(N-1)`, N even
rotating   on a ring, nearest two as neighbours                 :math:`\cos(2\pi/N)`
random     straight on, each in a direction of its own          :math:`(‖Σe_i‖^2 - N)/(N(N-1))`
stopped    nothing, headings parallel                           headings 1, motion undefined
========== ==================================================== ==============================
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.analysis import analyse
from posflock_robotarium.alignment.options import AnalysisOptions
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.logs.readers import Run
from rps_compat.testbed import TIME_STEP

Floats = NDArray[np.float64]

MOTIONS = ("parallel", "counter", "rotating", "random", "stopped")
POSITION_NOISE = 0.0005
"""Metres, standard deviation of each coordinate."""

HEADING_NOISE = 0.0015
"""Radians."""

EVERYBODY = 100.0
"""Neighbour radius in metres that makes every robot a neighbour of every other."""


@dataclass(frozen=True, eq=False)
class KnownFlock:
    """A recording and the γ it must yield.

    Attributes
    ----------
    recording : Run
        What a tracking system sees of it.
    radius : float
        Neighbour radius, m.
    gamma_headings, gamma_motion : float
        γ from where robots point, and from where they go.
    """

    recording: Run
    radius: float
    gamma_headings: float
    gamma_motion: float


def known_flock(
    motion: str,
    speed: float,
    *,
    robots: int = 10,
    duration: float = 60.0,
    position_noise: float = POSITION_NOISE,
    heading_noise: float = HEADING_NOISE,
    seed: int = 0,
) -> KnownFlock:
    """Return a flock of known γ.

    Parameters
    ----------
    motion : str
        One of `MOTIONS`.
    speed : float
        m/s.
    robots : int
        Number of robots, even and at least 4.
    duration : float
        Seconds.
    position_noise, heading_noise : float
        Standard deviations in metres and radians.
    seed : int
        Of noise, places and random directions.

    Returns
    -------
    KnownFlock
        Noisy poses, the neighbour radius to use, and the truth.

    Raises
    ------
    ParameterError
        For an unknown motion or an odd number of robots.
    """
    if motion not in MOTIONS:
        raise ParameterError(f"motion {motion!r} is none of {', '.join(MOTIONS)}")
    if robots < 4 or robots % 2:
        raise ParameterError(f"{robots} robots; expected an even number, at least 4")
    rng = np.random.default_rng(seed)
    t: Floats = TIME_STEP * np.arange(round(duration / TIME_STEP), dtype=float)
    start = rng.uniform(-1.0, 1.0, (2, robots))
    if motion == "rotating":
        poses, radius, gamma = _ring(t, robots, speed)
    else:
        angles = _angles(motion, robots, rng)
        poses, gamma = _straight_on(t, start, angles, 0.0 if motion == "stopped" else speed)
        radius = EVERYBODY
    poses[:, :2] += position_noise * rng.standard_normal(poses[:, :2].shape)
    poses[:, 2] += heading_noise * rng.standard_normal(poses[:, 2].shape)
    moving = float("nan") if motion == "stopped" else gamma
    return KnownFlock(Run(f"{motion} {speed:g}", t, poses), radius, gamma, moving)


def _ring(t: Floats, robots: int, speed: float) -> tuple[Floats, float, float]:
    """Return poses on a ring, the radius that makes the nearest two neighbours, and γ."""
    ring = 0.8
    angle = 2 * np.pi * np.arange(robots) / robots + speed / ring * t[:, np.newaxis]
    poses: Floats = np.stack(
        [ring * np.cos(angle), ring * np.sin(angle), angle + np.pi / 2], axis=1
    )
    # Between the chord to the next robot and the chord to the one after.
    radius = ring * (np.sin(np.pi / robots) + np.sin(2 * np.pi / robots))
    return poses, float(radius), float(np.cos(2 * np.pi / robots))


def _angles(motion: str, robots: int, rng: np.random.Generator) -> Floats:
    """Return the direction in which each robot points, radians."""
    # Drawn for every motion, so that all of them see the same noise.
    scattered = rng.uniform(-np.pi, np.pi, robots)
    if motion == "random":
        return scattered
    backwards = np.pi if motion == "counter" else 0.0
    return np.asarray(0.7 + backwards * (np.arange(robots) % 2), dtype=float)


def _straight_on(t: Floats, start: Floats, angles: Floats, speed: float) -> tuple[Floats, float]:
    """Return poses of robots that keep their direction, and γ of all of them as neighbours."""
    unit, robots = np.stack([np.cos(angles), np.sin(angles)]), len(angles)
    positions = start + (speed * t)[:, np.newaxis, np.newaxis] * unit
    headings = np.broadcast_to(angles, (len(t), 1, robots))
    together = float(np.square(unit.sum(axis=1)).sum())
    poses: Floats = np.concatenate([positions, headings], axis=1)
    return poses, (together - robots) / (robots * (robots - 1))


@dataclass(frozen=True)
class EstimatorError:
    """What one estimator makes of one flock.

    Attributes
    ----------
    motion, speed, estimator
        Which.
    truth, estimate : float
        γ, mean over time; NaN where undefined.
    left_out : float
        Mean share of robots that the estimate does not count.
    """

    motion: str
    speed: float
    estimator: str
    truth: float
    estimate: float
    left_out: float

    @property
    def error(self) -> float:
        """Estimate less truth."""
        return self.estimate - self.truth


def errors(
    motions: tuple[str, ...] = MOTIONS,
    speeds: tuple[float, ...] = (0.05, 0.1, 0.2),
    *,
    position_noise: float = POSITION_NOISE,
    heading_noise: float = HEADING_NOISE,
    seed: int = 0,
) -> list[EstimatorError]:
    """Return the error of every estimator for every motion and speed.

    Parameters
    ----------
    motions, speeds : tuple
        Which flocks.
    position_noise, heading_noise : float
        Standard deviations in metres and radians.
    seed : int
        Of the flocks.
    """
    found = []
    for motion in motions:
        for speed in (0.0,) if motion == "stopped" else speeds:
            flock = known_flock(
                motion,
                speed,
                position_noise=position_noise,
                heading_noise=heading_noise,
                seed=seed,
            )
            analysis = analyse(flock.recording, AnalysisOptions(radius=flock.radius, transient=0.0))
            for short, truth in (
                ("headings", flock.gamma_headings),
                ("motion", flock.gamma_motion),
                ("differences", flock.gamma_motion),
            ):
                found.append(
                    EstimatorError(
                        motion,
                        speed,
                        short,
                        truth,
                        analysis.numbers[f"gamma_{short}"].value,
                        analysis.numbers[f"left_out_{short}"].value,
                    )
                )
    return found
