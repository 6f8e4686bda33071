"""Every quantity the report knows: its name, unit and definition, in one place.

The page, the figures, the CSV header, the LaTeX table and the JSON all take their words from here,
so that a number is defined the same wherever it is read.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Reduction = Literal["mean", "smallest", "largest"]


@dataclass(frozen=True)
class Quantity:
    """One curve over time.

    Attributes
    ----------
    key : str
        Column name in CSV and JSON.
    label, unit, definition : str
        Words for people; the unit is empty for pure numbers.
    of_interest : {'mean', 'smallest', 'largest'}
        Which summary of the curve a reader looks for first, and what a coarser drawing keeps.
    """

    key: str
    label: str
    unit: str
    definition: str
    of_interest: Reduction = "mean"


@dataclass(frozen=True)
class Panel:
    """Curves that are drawn in one plot because they share an axis.

    Attributes
    ----------
    key : str
        Name of the plot in JSON.
    title : str
        Words for people.
    unit : str
        Of the axis; empty for pure numbers.
    curves : tuple of str
        Keys of its quantities.
    limits : (float or None, float or None)
        Ends of the axis that are fixed.
    lines : tuple of (float, str)
        Values that are marked, and what they are.
    """

    key: str
    title: str
    unit: str
    curves: tuple[str, ...]
    limits: tuple[float | None, float | None] = (None, None)
    lines: tuple[tuple[float, str], ...] = ()


QUANTITIES: tuple[Quantity, ...] = (
    Quantity(
        "gamma_headings",
        "γ from headings",
        "",
        "Mean over robots of the mean cosine between a robot's heading and its neighbours'. "
        "Where robots point: parked robots have headings too.",
    ),
    Quantity(
        "gamma_motion",
        "γ from motion",
        "",
        "The same with directions of motion, estimated by a Savitzky-Golay derivative. "
        "Where robots go.",
    ),
    Quantity(
        "gamma_differences",
        "γ from raw differences",
        "",
        "The same with one-frame differences of position. Biased downwards by tracking noise; "
        "shown for comparison only.",
    ),
    Quantity(
        "left_out_headings",
        "left out, headings",
        "",
        "Share of robots that γ from headings does not count, having no neighbour.",
        "largest",
    ),
    Quantity(
        "left_out_motion",
        "left out, motion",
        "",
        "Share of robots that γ from motion does not count: too slow to have a direction, or "
        "without a neighbour that moves.",
    ),
    Quantity(
        "left_out_differences",
        "left out, raw differences",
        "",
        "Share of robots that γ from raw differences does not count.",
    ),
    Quantity(
        "polarisation_headings",
        "polarisation, headings",
        "",
        "Length of the mean of the heading unit vectors: 1 when all robots point one way.",
    ),
    Quantity(
        "polarisation_motion",
        "polarisation, motion",
        "",
        "Length of the mean of the unit directions of motion.",
    ),
    Quantity(
        "heading",
        "heading of the flock",
        "rad",
        "Angle of the mean heading vector; undefined where polarisation is below 0.1.",
    ),
    Quantity(
        "speed",
        "mean speed",
        "m/s",
        "Mean over robots of the Savitzky-Golay speed.",
    ),
    Quantity(
        "speed_slowest",
        "slowest robot",
        "m/s",
        "Smallest Savitzky-Golay speed of a robot.",
        "smallest",
    ),
    Quantity(
        "speed_fastest",
        "fastest robot",
        "m/s",
        "Largest Savitzky-Golay speed of a robot.",
        "largest",
    ),
    Quantity(
        "drift",
        "speed of the centroid",
        "m/s",
        "Speed at which the flock as a whole travels.",
    ),
    Quantity(
        "nearest_neighbour",
        "nearest neighbour, mean",
        "m",
        "Mean over robots of the distance to the nearest other robot, centre to centre.",
    ),
    Quantity(
        "smallest_distance",
        "closest pair",
        "m",
        "Smallest distance between two robots' centres.",
        "smallest",
    ),
    Quantity(
        "smallest_collision_distance",
        "closest pair, collision points",
        "m",
        "Smallest distance between the points ahead of the centres that the testbed's collision "
        "test looks at.",
        "smallest",
    ),
    Quantity(
        "wall_distance",
        "distance to the nearest wall",
        "m",
        "Smallest distance of a robot's centre to the arena's boundary; negative outside.",
        "smallest",
    ),
    Quantity(
        "cohesive_radius",
        "cohesive radius",
        "m",
        "Largest distance of a robot from the centroid.",
        "largest",
    ),
    Quantity(
        "spread",
        "spread",
        "m",
        "Root mean square distance of the robots from the centroid.",
    ),
    Quantity(
        "components",
        "connected components",
        "",
        "Number of groups that no chain of neighbours connects.",
        "largest",
    ),
    Quantity(
        "algebraic_connectivity",
        "algebraic connectivity",
        "",
        "Second smallest eigenvalue of the neighbour graph's Laplacian: 0 when the flock has "
        "parted, N when every robot neighbours every other.",
        "smallest",
    ),
    Quantity(
        "fastest_wheel",
        "fastest wheel asked for",
        "rad/s",
        "Largest wheel speed that the logged commands ask for.",
        "largest",
    ),
    Quantity(
        "intervention",
        "intervention of the certificate",
        "m/s",
        "How far the safety certificate changed a robot's velocity, at most.",
        "largest",
    ),
    Quantity(
        "clearance",
        "clearance of the certificate",
        "m",
        "Distance beyond what the certificate keeps between look-ahead points and from walls; "
        "negative where the team is unsafe.",
        "smallest",
    ),
)

BY_KEY = {quantity.key: quantity for quantity in QUANTITIES}


def panels(collision: float) -> tuple[Panel, ...]:
    """Return the plots of the page, in reading order.

    Parameters
    ----------
    collision : float
        The testbed's collision diameter in metres, drawn as a line.
    """
    return (
        Panel(
            "alignment",
            "Alignment",
            "γ",
            ("gamma_motion", "gamma_headings", "gamma_differences"),
            (None, 1.02),
        ),
        Panel(
            "left_out",
            "Robots left out of γ",
            "share",
            ("left_out_motion", "left_out_headings"),
            (0.0, 1.02),
        ),
        Panel(
            "polarisation",
            "Polarisation",
            "",
            ("polarisation_motion", "polarisation_headings"),
            (0.0, 1.02),
        ),
        Panel(
            "speed", "Speed", "m/s", ("speed", "drift", "speed_slowest", "speed_fastest"), (0, None)
        ),
        Panel(
            "distance",
            "Distances between robots",
            "m",
            ("nearest_neighbour", "smallest_distance", "smallest_collision_distance"),
            (0.0, None),
            ((collision, "collision"),),
        ),
        Panel(
            "walls",
            "Distance to the nearest wall",
            "m",
            ("wall_distance",),
            (None, None),
            ((0.0, "wall"),),
        ),
        Panel("cohesion", "Cohesion", "m", ("cohesive_radius", "spread"), (0.0, None)),
        Panel(
            "connectivity",
            "Connectivity",
            "",
            ("components", "algebraic_connectivity"),
            (0.0, None),
        ),
        Panel("heading", "Heading of the flock", "rad", ("heading",)),
        Panel("certificate", "Certificate", "m/s", ("intervention",), (0.0, None)),
        Panel("clearance", "Clearance", "m", ("clearance",), (None, None), ((0.0, "unsafe"),)),
        Panel("wheels", "Fastest wheel", "rad/s", ("fastest_wheel",), (0.0, None)),
    )
