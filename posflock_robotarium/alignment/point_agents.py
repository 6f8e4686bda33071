"""What became of a flock in free space: every metric over time, and the numbers of a table.

:func:`measure` applies the definitions of :mod:`posflock_robotarium.alignment.metrics` to a
recording; :func:`summarise` reduces the result to the numbers that a row of a study or a
claim about the paper needs.  Both work along the last axis, time, for one flock or a batch.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.alignment import metrics
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.freespace.simulation import PointRun

Floats = NDArray[np.float64]

#: A flock counts as aligned from this γ on.
ALIGNED = 0.9

#: The variances are over all n² pairs; beyond so many agents they are left out.
_ALL_PAIRS_UP_TO = 1_000

#: Numbers in one (rows, n, n) array that still fits the processor's cache.
_CACHED_NUMBERS = 20_000


@dataclass(frozen=True, eq=False)
class Measures:
    """Every metric over time; arrays are (T,) for one flock or (B, T) for a batch.

    Agents that fail at some time of the run are left out from its start.

    Attributes
    ----------
    times : (T,) array
        Seconds.
    gamma : (..., T) array
        Alignment γ.
    counted : (..., T) array
        Agents in the mean of γ: those that move and have a neighbour.
    nearest_neighbour : (..., T) array
        Mean distance to the nearest other, metres.
    closest_pair : (..., T) array
        Smallest distance between any two, metres.
    speed : (..., T) array
        Mean speed, m/s.
    cohesive_radius : (..., T) array
        Largest distance from the centroid, metres.
    distance_variance : (..., T) array
        Variance of the pairwise distances, m²; NaN above a thousand agents, whose n² pairs are not
        looked at.
    change_variance : (..., T) array
        Variance of the change of pairwise distances since t = 0, m²; NaN likewise.
    components : (..., T) array
        Groups that are not linked by any neighbour.
    centroid_velocity : (..., T, d) array
        Mean velocity, m/s.
    """

    times: Floats
    gamma: Floats
    counted: Floats
    nearest_neighbour: Floats
    closest_pair: Floats
    speed: Floats
    cohesive_radius: Floats
    distance_variance: Floats
    change_variance: Floats
    components: Floats
    centroid_velocity: Floats

    def __getitem__(self, flock: int) -> Measures:
        """Return one flock of a batch."""
        return Measures(
            self.times,
            **{f.name: getattr(self, f.name)[flock] for f in fields(self) if f.name != "times"},
        )


def measure(recording: PointRun, radius: float | Floats) -> Measures:
    """Apply every metric to a recording.

    Parameters
    ----------
    recording : PointRun
        Of one flock or of a batch.
    radius : float or (n,) array
        Interaction radius in metres, which says who is whose neighbour.

    Returns
    -------
    Measures
        One value a recorded time, of the agents that do not fail.
    """
    if recording.positions.ndim == 3:
        return _measure_flock(recording, radius)
    flocks = [_measure_flock(recording[b], radius) for b in range(len(recording.positions))]
    return stack(flocks)


def stack(flocks: list[Measures]) -> Measures:
    """Make one batch of flocks that were recorded at the same times.

    Parameters
    ----------
    flocks : list of Measures
        The flocks, arrays (T,) each.

    Raises
    ------
    ParameterError
        Where there is none.
    """
    if not flocks:
        raise ParameterError("flocks: expected at least one, got none")
    return Measures(
        flocks[0].times,
        **{
            f.name: np.stack([getattr(flock, f.name) for flock in flocks])
            for f in fields(Measures)
            if f.name != "times"
        },
    )


def summarise(measures: Measures) -> dict[str, Floats]:
    """Reduce each run to the numbers of a table.

    Windows are shares of the duration, so that of the paper's 100 s "settled" is from 20 s
    on.  A number is NaN where γ is unknown at some instant of its window.

    Parameters
    ----------
    measures : Measures
        Of one flock or of a batch.

    Returns
    -------
    dict of str to () or (B,) array
        In the units of :class:`Measures`; ``heading_spread`` in degrees,
        ``alignment_time`` in seconds, infinite for a run that never aligned; ``gamma_5s`` and
        ``gamma_30s`` are absent of a run that ended before.
    """
    times, end = measures.times, measures.times[-1]
    window = _Window(times / end)
    gamma = measures.gamma
    radius = window.rows(measures.cohesive_radius, 0.1, 1.0)
    return {
        "gamma_settled": window.mean(gamma, 0.2, 1.0),
        **_at_times(times, gamma),
        "gamma_end": gamma[..., -1],
        "gamma_change": window.mean(gamma, 0.8, 1.0) - window.mean(gamma, 0.1, 0.3),
        "gamma_fluctuation": np.std(window.rows(gamma, 0.3, 1.0), axis=-1),
        "alignment_time": _first_time(times, gamma >= ALIGNED),
        "nearest_neighbour_settled": window.mean(measures.nearest_neighbour, 0.2, 1.0),
        "nearest_neighbour_end": measures.nearest_neighbour[..., -1],
        "closest_pair": measures.closest_pair.min(axis=-1),
        "speed_end": measures.speed[..., -1],
        "cohesive_radius_end": measures.cohesive_radius[..., -1],
        "cohesive_radius_ratio": radius.max(axis=-1) / radius.min(axis=-1),
        "heading_spread": _heading_spread(
            window.rows(np.moveaxis(measures.centroid_velocity, -1, 0), 0.2, 1.0)
        ),
        "distance_variance_start": measures.distance_variance[..., 0],
        "distance_variance_end": measures.distance_variance[..., -1],
        "change_variance_settled": window.mean(measures.change_variance, 0.2, 1.0),
        "components_end": measures.components[..., -1],
    }


def _at_times(times: Floats, gamma: Floats) -> dict[str, Floats]:
    """Return γ at the times that the run came to."""
    return {
        f"gamma_{second}s": np.asarray(gamma[..., ties.first_smallest(np.abs(times - second))])
        for second in (5, 30)
        if ties.reached(times[-1], second)
    }


class _Window:
    """Rows of a run between two shares of its duration."""

    def __init__(self, shares: Floats) -> None:
        self._shares = shares

    def rows(self, values: Floats, start: float, end: float) -> Floats:
        # A slice and not a mask: a run is then summed in one order, alone and in a batch.
        first, last = np.searchsorted(self._shares, (start - ties.TIE, end + ties.TIE))
        # A run recorded so seldom that no row is inside is judged by the next one.
        first = min(first, len(self._shares) - 1)
        return values[..., first : max(last, first + 1)]

    def mean(self, values: Floats, start: float, end: float) -> Floats:
        return np.asarray(np.mean(self.rows(values, start, end), axis=-1))


def _first_time(times: Floats, reached: NDArray[np.bool_]) -> Floats:
    return np.where(reached.any(axis=-1), times[reached.argmax(axis=-1)], np.inf)


def _heading_spread(velocity: Floats) -> Floats:
    """Return the largest angle, degrees, between two directions of (d, ..., T) velocities."""
    speed = np.sqrt(np.square(velocity).sum(axis=0))
    direction = np.divide(velocity, speed, out=np.zeros_like(velocity), where=speed > 0.0)
    cosines = np.einsum("d...t,d...s->...ts", direction, direction)
    return np.asarray(np.degrees(np.arccos(np.clip(cosines.min(axis=(-2, -1)), -1.0, 1.0))))


def _measure_flock(recording: PointRun, radius: float | Floats) -> Measures:
    surviving = ~recording.failing
    reach = radius[surviving] if isinstance(radius, np.ndarray) else radius
    p, v = recording.positions[..., surviving], recording.velocities[..., surviving]
    # A few rows at a time: the (rows, n, n) arrays stay in the cache.
    rows = max(1, _CACHED_NUMBERS // p.shape[-1] ** 2)
    parts = [
        _measure_rows(p[at : at + rows], v[at : at + rows], p[0], reach)
        for at in range(0, len(p), rows)
    ]
    return Measures(
        recording.times,
        **{name: np.concatenate([part[name] for part in parts]) for name in parts[0]},
    )


def _measure_rows(p: Floats, v: Floats, first: Floats, radius: float | Floats) -> dict[str, Floats]:
    alignment = metrics.alignment(v, p, radius)
    few = p.shape[-1] <= _ALL_PAIRS_UP_TO
    unknown = np.full(len(p), np.nan)
    return {
        "gamma": alignment.gamma,
        "counted": alignment.counted,
        "nearest_neighbour": metrics.nearest_neighbour_distance(p),
        "closest_pair": metrics.smallest_distance(p),
        "speed": metrics.mean_speed(v),
        "cohesive_radius": metrics.cohesive_radius(p),
        "distance_variance": metrics.pairwise_distance_variance(p) if few else unknown,
        "change_variance": metrics.pairwise_change_variance(p, first) if few else unknown,
        "components": metrics.connected_components(p, radius),
        "centroid_velocity": v.mean(axis=-1),
    }
