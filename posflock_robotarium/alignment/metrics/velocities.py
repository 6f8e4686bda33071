"""Velocities from positions, how fast a flock is, and how fast wheels have to turn."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from posflock_robotarium.alignment.metrics.states import checked_states, checked_track
from posflock_robotarium.flocking.errors import ParameterError

Floats = NDArray[np.float64]

#: Logged poses jitter; eleven points (0.36 s) of a quadratic restore directions to a mean
#: cosine of 0.9997 where one-frame differences give 0.97 at 0.05 m/s.
SMOOTHING_POINTS = 11

#: m/s up to which a robot seen by the tracker has no direction of motion: seven times the speed
#: that 0.5 mm of noise pretends within those eleven points.  Whatever judges a log takes it.
SLOWEST = 0.01


def velocities_by_differences(positions: ArrayLike, time_step: float) -> Floats:
    """Return velocities by one-frame differences.

    Exact for simulated poses; for tracked ones see :func:`smoothed_velocities`.  The first
    row repeats the second, so that rows and times still correspond.

    Parameters
    ----------
    positions : (T, d, N) array
        Evenly sampled positions, m.
    time_step : float
        Seconds between rows.

    Returns
    -------
    (T, d, N) array
        Velocities, m/s.
    """
    p = checked_track(positions, 2)
    step = np.diff(p, axis=0) / time_step
    return np.concatenate([step[:1], step])


def smoothed_velocities(
    positions: ArrayLike, time_step: float, points: int = SMOOTHING_POINTS
) -> Floats:
    """Return velocities by the Savitzky-Golay derivative.

    Parameters
    ----------
    positions : (T, d, N) array
        Evenly sampled, metres.
    time_step : float
        Seconds between rows.
    points : int
        Odd length of the window; a quadratic is fitted to each.

    Returns
    -------
    (T, d, N) array
        Velocities, m/s.

    Raises
    ------
    ParameterError
        Where the window is not odd, or longer than the run.
    """
    p = checked_track(positions, points)
    if points < 3 or points % 2 == 0:
        raise ParameterError(f"points: expected an odd number from 3, got {points}")
    # By the closed form of evenly spaced samples: scipy.signal takes as long to import as an hour
    # of poses takes here.
    half = points // 2
    inner, offsets = len(p) - 2 * half, np.arange(1, half + 1)
    slope = np.zeros((inner, *p.shape[1:]))
    for k in offsets.tolist():
        slope += k * (p[half + k : half + k + inner] - p[half - k : half - k + inner])
    slope /= 2.0 * np.square(offsets).sum() * time_step
    # Nearer to an end than half a window, the fit to the first or last whole window is followed.
    bend = np.square(np.arange(-half, half + 1)) - np.square(offsets).sum() * 2.0 / points
    bend /= np.square(bend).sum() * time_step
    steps = 2.0 * offsets[:, np.newaxis, np.newaxis]
    first = slope[0] - steps[::-1] * np.tensordot(bend, p[:points], axes=1)
    last = slope[-1] + steps * np.tensordot(bend, p[-points:], axes=1)
    return np.concatenate([first, slope, last])


def mean_speed(velocities: ArrayLike) -> Floats:
    """Return the mean over agents of ‖v_i‖.

    Parameters
    ----------
    velocities : (..., d, N) array
        Velocities, m/s.

    Returns
    -------
    (...) array
        The mean, m/s.
    """
    return np.asarray(np.sqrt(np.square(checked_states(velocities, "velocities")).sum(-2)).mean(-1))


def fastest_wheel(commands: ArrayLike, wheel_radius: float, base_length: float) -> Floats:
    """Return the highest |wheel speed| that commands ask for.

    Parameters
    ----------
    commands : (..., 2, N) array
        Forward speeds v, m/s, and turn rates ω, rad/s.
    wheel_radius : float
        Radius of the wheels, m.
    base_length : float
        From wheel to wheel, m.

    Returns
    -------
    (...) array
        The speed, rad/s, of the commands that are known; NaN where none is.
    """
    u = np.asarray(commands, dtype=float)
    fastest = np.abs(u[..., 0, :]) + np.abs(u[..., 1, :]) * (base_length / 2.0)
    return np.asarray(np.fmax.reduce(fastest, axis=-1) / wheel_radius)
