"""How close robots come to the walls, and how often one leaves the arena."""

from __future__ import annotations

from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.faults import count, faults_of
from posflock_robotarium.alignment.measured_run import Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import Metric, Scalar, register
from posflock_robotarium.alignment.panels import WALLS
from posflock_robotarium.alignment.reductions import smallest
from rps_compat.violations import FaultKind


def _wall_distance(run: MeasuredRun) -> Floats:
    arena = run.robot.boundaries
    return run.by_stretch(lambda stretch: metrics.wall_distance(run.positions[stretch], arena))


register(
    Metric(
        "wall_distance",
        "distance to the nearest wall",
        "m",
        "Smallest distance of a robot's centre to the arena's boundary; negative outside.",
        _wall_distance,
        "smallest",
        panel=WALLS,
        figure="distances",
        legend="nearest wall",
        numbers=(
            Scalar(
                "smallest_wall_distance",
                "smallest distance to a wall",
                "m",
                "Of a robot's centre, whole run; negative outside.",
                "Safety",
                smallest("wall_distance"),
                latex=True,
            ),
            Scalar(
                "boundary_events",
                "boundary crossings",
                "",
                "Times a robot's centre left the arena.",
                "Safety",
                lambda run: count(run, FaultKind.BOUNDARY),
            ),
            Scalar(
                "boundary_steps",
                "steps with a robot outside",
                "",
                "Samples.",
                "Safety",
                lambda run: run.once(faults_of).outside_steps,
            ),
        ),
    ),
)
