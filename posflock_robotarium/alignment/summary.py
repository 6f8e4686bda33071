"""A run in a dozen numbers, which answer: did it align, did it move, was it safe.

No number is defined here: a summary is a selection of the numbers that the report knows, and
computes no other.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.analysis import Analysis
from posflock_robotarium.alignment.catalogue import scalars
from posflock_robotarium.alignment.measured_run import MeasuredRun
from posflock_robotarium.alignment.measuring import measure
from posflock_robotarium.alignment.options import AnalysisOptions
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.run import Run


@dataclass(frozen=True)
class Summary:
    """The figures that a nine-robot run is judged by.

    Means are over the time after ``settled`` seconds, or over all of a shorter run.  A figure
    that is unknown or undefined is NaN, a count None: never 0.

    Attributes
    ----------
    duration, settled : float
        From the first pose to the end of the last step; after which means are taken.  Seconds.
    gamma_headings, gamma_motion : float
        Mean γ from where robots point and from where they go (Savitzky-Golay; robots no faster
        than `metrics.SLOWEST` have no direction), as the report has it; NaN where undefined.
    mean_speed : float
        m/s.
    smallest_distance, smallest_wall_distance : float
        Least distance between two centres, and of a centre from a wall, in the whole run, m;
        the walls are those of the run's own arena.
    fastest_wheel : float
        Highest wheel speed commanded, rad/s, of the run's own robot.
    collisions, steps_outside, steps_infeasible : int, optional
        Pairs in collision summed over steps; steps with a centre outside the arena; steps
        whose certificate was not solved as it stands.  None where unknown.
    smallest_clearance : float
        Least distance beyond what the certificate keeps, between look-ahead points and from walls,
        m; negative where the team was unsafe.  As the certificate saw it.
    share_intervened, largest_intervention : float
        Share of steps in which the certificate changed a velocity by more than 1 mm/s, and by how
        much at most, m/s.
    ended : str, optional
        How the run ended.
    local : bool, optional
        Whether each robot decided by what it senses and hears alone; None where the log does not
        say.
    """

    duration: float
    settled: float
    gamma_headings: float
    gamma_motion: float
    mean_speed: float
    smallest_distance: float
    smallest_wall_distance: float
    fastest_wheel: float
    collisions: int | None
    steps_outside: int | None
    steps_infeasible: int | None
    smallest_clearance: float
    share_intervened: float
    largest_intervention: float
    ended: str | None
    local: bool | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return the numbers under their names, ready for JSON; what is undefined is None."""
        return {
            name: None if isinstance(value, float) and math.isnan(value) else value
            for name, value in asdict(self).items()
        }

    def __str__(self) -> str:
        since = f"t > {self.settled:g} s"
        unsolved = "unknown" if self.steps_infeasible is None else self.steps_infeasible
        return "\n".join(
            [
                f"run of {self.duration:.1f} s, {self.ended or 'unknown how it ended'}"
                + ("; each robot by what it senses and hears" if self.local else ""),
                f"  alignment γ, {since}    headings {_told(self.gamma_headings, '.3f')}"
                f"   motion {_told(self.gamma_motion, '.3f')}",
                f"  mean speed, {since}     {_told(self.mean_speed, '.3f', ' m/s')}",
                f"  smallest distance        robots {_told(self.smallest_distance, '.3f', ' m')}"
                f"   wall {_told(self.smallest_wall_distance, '.3f', ' m')}",
                f"  fastest wheel            {_told(self.fastest_wheel, '.1f', ' rad/s')}",
                f"  collisions {self.collisions or 0}, steps outside {self.steps_outside},"
                f" infeasible certificates {unsolved}",
                f"  smallest clearance       {_told(self.smallest_clearance, '.3f', ' m')}",
                f"  certificate intervened   {_told(self.share_intervened, '.1%', ' of steps')},"
                f" by {_told(self.largest_intervention, '.3f', ' m/s')} at most",
            ]
        )


def summarise(run: Run, radius: float | None = None) -> Summary:
    """Return the figures of a run.

    Parameters
    ----------
    run : Run
        What was recorded.
    radius : float, optional
        Neighbour radius in metres; by default what the log says.

    Raises
    ------
    LogError
        Where the run is too short for velocities, or no neighbour radius is known.
    """
    if len(run.t) < metrics.SMOOTHING_POINTS:
        raise LogError(
            f"{run.name}: {len(run.t)} rows; at least {metrics.SMOOTHING_POINTS} are needed to tell"
            " directions of motion"
        )
    measured, known = measure(run, AnalysisOptions(radius=radius)), scalars()
    return _summary(measured, lambda key: known[key].value(measured))


def summary_of(analysis: Analysis) -> Summary:
    """Return the figures of a run that has been analysed.

    Parameters
    ----------
    analysis : Analysis
        What was computed of the run.
    """

    def value(key: str) -> float | None:
        number = analysis.numbers.get(key)
        return None if number is None else number.value

    return _summary(analysis, value)


def _summary(run: Analysis | MeasuredRun, value: Callable[[str], float | None]) -> Summary:
    def of(key: str) -> float:
        found = value(key)
        return math.nan if found is None else float(found)

    def count(key: str) -> int | None:
        found = of(key)
        return None if math.isnan(found) else int(found)

    ending, local = run.recording.ending, run.recording.parameters.get("local")
    return Summary(
        duration=of("duration") + of("step"),
        settled=0.0 if run.settled.all() else run.transient,
        gamma_headings=of("gamma_headings"),
        gamma_motion=of("gamma_motion"),
        mean_speed=of("speed"),
        smallest_distance=of("smallest_distance"),
        smallest_wall_distance=of("smallest_wall_distance"),
        fastest_wheel=of("fastest_wheel"),
        collisions=count("collision_steps"),
        steps_outside=count("boundary_steps"),
        steps_infeasible=count("unsolved"),
        smallest_clearance=of("clearance"),
        share_intervened=of("interventions"),
        largest_intervention=of("intervention_largest"),
        ended=None if ending is None else ending.how.value,
        local=local if isinstance(local, bool) else None,
    )


def _told(value: float, form: str, unit: str = "") -> str:
    return "unknown" if math.isnan(value) else f"{value:{form}}{unit}"
