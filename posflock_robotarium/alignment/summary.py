"""A run in a dozen numbers, which answer: did it align, did it move, was it safe."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from barrier_certificates import ties
from posflock_robotarium.alignment import metrics
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.flocking.pose_log import INTERVENED, Log

#: Seconds after which the flock should have aligned: means are taken from here on.
SETTLED = 20.0


@dataclass(frozen=True)
class Summary:
    """The figures that a nine-robot run is judged by.

    Means are over the time after ``settled`` seconds, or over all of a shorter run.

    Attributes
    ----------
    duration, settled : float
        Seconds.
    gamma_headings, gamma_motion : float
        Mean γ from where robots point and from where they go (Savitzky-Golay; robots no faster
        than `metrics.SLOWEST` have no direction), as the report has it; NaN where undefined.
    mean_speed : float
        m/s.
    smallest_distance, smallest_wall_distance : float
        Least distance between two centres, and of a centre from a wall, in the whole run, m.
    fastest_wheel : float
        Highest wheel speed commanded, rad/s.
    collisions, steps_outside, steps_infeasible : int
        Pairs in collision summed over steps; steps with a centre outside the arena; steps
        whose certificate was not solved as it stands.
    smallest_clearance : float
        Least distance beyond what the certificate keeps, between look-ahead points and from walls,
        m; negative where the team was unsafe.  As the certificate saw it; NaN where it is unknown.
    share_intervened, largest_intervention : float
        Share of steps in which the certificate changed a velocity by more than 1 mm/s, and by how
        much at most, m/s; NaN without a certificate.
    ended : str
        How the run ended.
    """

    duration: float
    settled: float
    gamma_headings: float
    gamma_motion: float
    mean_speed: float
    smallest_distance: float
    smallest_wall_distance: float
    fastest_wheel: float
    collisions: int
    steps_outside: int
    steps_infeasible: int
    smallest_clearance: float
    share_intervened: float
    largest_intervention: float
    ended: str

    def as_dict(self) -> dict[str, Any]:
        """Return the numbers under their names, ready for JSON; what is undefined is None."""
        return {
            name: None if isinstance(value, float) and math.isnan(value) else value
            for name, value in asdict(self).items()
        }

    def __str__(self) -> str:
        since = f"t > {self.settled:g} s"
        return "\n".join(
            [
                f"run of {self.duration:.1f} s, {self.ended}",
                f"  alignment γ, {since}    headings {self.gamma_headings:.3f}"
                f"   motion {self.gamma_motion:.3f}",
                f"  mean speed, {since}     {self.mean_speed:.3f} m/s",
                f"  smallest distance        robots {self.smallest_distance:.3f} m"
                f"   wall {self.smallest_wall_distance:.3f} m",
                f"  fastest wheel            {self.fastest_wheel:.1f} rad/s",
                f"  collisions {self.collisions}, steps outside {self.steps_outside},"
                f" infeasible certificates {self.steps_infeasible}",
                f"  smallest clearance       {_told(self.smallest_clearance, '.3f', ' m')}",
                f"  certificate intervened   {_told(self.share_intervened, '.1%', ' of steps')},"
                f" by {_told(self.largest_intervention, '.3f', ' m/s')} at most",
            ]
        )


def summarise(log: Log, radius: float | None = None, settled: float = SETTLED) -> Summary:
    """Return the figures of a run.

    Parameters
    ----------
    log : Log
        What was recorded.
    radius : float, optional
        Neighbour radius in metres; by default what the log says.
    settled : float
        Seconds from which means are taken.

    Raises
    ------
    LogError
        Where the log is too short for velocities, or no neighbour radius is known.
    """
    if len(log.t) < metrics.SMOOTHING_POINTS:
        raise LogError(
            f"the log holds {len(log.t)} rows; at least {metrics.SMOOTHING_POINTS} are needed"
            " to tell directions of motion"
        )
    radius = log.neighbour_radius(radius)
    time_step = log.time_step
    positions = log.poses[:, :2]
    velocities = metrics.smoothed_velocities(positions, time_step)
    late = ties.beyond(log.t, settled)
    if not late.any():
        settled, late = 0.0, np.ones(len(log.t), dtype=bool)
    headings = metrics.heading_vectors(log.poses[late])
    motion = metrics.alignment(velocities[late], positions[late], radius, slowest=metrics.SLOWEST)
    walls = metrics.wall_distance(positions)
    return Summary(
        duration=float(log.t[-1] + time_step),
        settled=settled,
        gamma_headings=_mean(metrics.alignment(headings, positions[late], radius).gamma),
        gamma_motion=_mean(motion.gamma),
        mean_speed=float(metrics.mean_speed(velocities[late]).mean()),
        smallest_distance=float(metrics.smallest_distance(positions).min()),
        smallest_wall_distance=float(walls.min()),
        fastest_wheel=float(metrics.fastest_wheel(log.commands).max()),
        collisions=int(metrics.colliding_pairs(log.poses).sum()),
        steps_outside=int(ties.short_of(walls, 0.0).sum()),
        steps_infeasible=int(np.isin(log.status, ("relaxed", "failed")).sum()),
        smallest_clearance=_least(log.clearance),
        share_intervened=_mean(
            np.where(np.isnan(log.moved), np.nan, ties.beyond(log.moved, INTERVENED))
        ),
        largest_intervention=-_least(-log.moved),
        ended=str(log.metadata.get("ended", {}).get("how", "unknown")),
    )


def _mean(values: metrics.Floats) -> float:
    """Return the mean over the instants at which a value is defined; NaN where it never is."""
    known = values[~np.isnan(values)]
    return float(known.mean()) if known.size else float("nan")


def _least(values: metrics.Floats) -> float:
    """Return the least of the values that are known; NaN where none is."""
    known = values[~np.isnan(values)]
    return float(known.min()) if known.size else float("nan")


def _told(value: float, form: str, unit: str) -> str:
    return "unknown" if math.isnan(value) else f"{value:{form}}{unit}"
