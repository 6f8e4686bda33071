"""The plots of the page, in reading order: curves are drawn in one because they share an axis.

Which curves a plot shows is said by the metrics themselves (see `metric_registry.Metric`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from rps_compat.testbed import WATCHDOG, RobotModel


@dataclass(frozen=True)
class Line:
    """A level drawn across a plot.

    Attributes
    ----------
    label : str
        What lies there.
    level : callable
        Of the run's robot and arena, in the plot's unit.
    always : bool
        Whether the axis reaches it where the curves do not.
    """

    label: str
    level: Callable[[RobotModel], float] = lambda robot: 0.0
    always: bool = True


@dataclass(frozen=True)
class Panel:
    """One plot over time.

    Attributes
    ----------
    key : str
        What programs call the plot: a plain name that no other plot has.
    title : str
        What people read above the plot.
    unit : str
        What the vertical axis is in; empty for pure numbers.
    limits : pair of float
        Ends of that axis; None where the curves decide.
    lines : tuple of Line
        Levels to hold the curves against.
    leads : bool
        Whether it stands before all others: what somebody asked for himself.
    """

    key: str
    title: str
    unit: str
    limits: tuple[float | None, float | None] = (None, None)
    lines: tuple[Line, ...] = ()
    leads: bool = False


FORMATION = Panel("formation", "Formation", "m", (0.0, None))
COVERAGE = Panel("coverage", "Coverage", "m", (0.0, None))
ALIGNMENT = Panel("alignment", "Alignment", "γ", (None, 1.02))
LEFT_OUT = Panel("left_out", "Robots left out of γ", "share", (0.0, 1.02))
POLARISATION = Panel("polarisation", "Polarisation", "", (0.0, 1.02))
SPEED = Panel("speed", "Speed", "m/s", (0.0, None))
DISTANCE = Panel(
    "distance",
    "Distances between robots",
    "m",
    (0.0, None),
    (Line("collision", lambda robot: robot.collision_diameter),),
)
WALLS = Panel("walls", "Distance to the nearest wall", "m", lines=(Line("wall"),))
COHESION = Panel("cohesion", "Cohesion", "m", (0.0, None))
CONNECTIVITY = Panel("connectivity", "Connectivity", "", (0.0, None))
HEADING = Panel("heading", "Heading of the team", "rad")
SEEN = Panel("seen", "Robots seen", "", (0.0, None))
CERTIFICATE = Panel("certificate", "Certificate", "m/s", (0.0, None))
CLEARANCE = Panel("clearance", "Clearance", "m", lines=(Line("unsafe"),))
WHEELS = Panel("wheels", "Fastest wheel", "rad/s", (0.0, None))
STEPS = Panel(
    "steps",
    "Time that each step took",
    "s",
    (0.0, None),
    (Line("robots brake", lambda robot: WATCHDOG, always=False),),
)

OF_FLOCKS = (ALIGNMENT, LEFT_OUT, POLARISATION, HEADING)
"""Plots that answer whether a flock aligned."""

READING_ORDER = (
    FORMATION,
    COVERAGE,
    ALIGNMENT,
    LEFT_OUT,
    SEEN,
    POLARISATION,
    SPEED,
    DISTANCE,
    WALLS,
    COHESION,
    CONNECTIVITY,
    HEADING,
    CERTIFICATE,
    CLEARANCE,
    WHEELS,
    STEPS,
)


def in_reading_order(panels: Iterable[Panel]) -> list[Panel]:
    """Return each plot once: those that lead, those of `READING_ORDER`, any other as it comes.

    Parameters
    ----------
    panels : iterable of Panel
        The plots that are wanted, repeated or not.
    """
    wanted = list(dict.fromkeys(panels))
    first = [panel for panel in wanted if panel.leads]
    first += [panel for panel in READING_ORDER if panel in wanted]
    return first + [panel for panel in wanted if panel not in first]
