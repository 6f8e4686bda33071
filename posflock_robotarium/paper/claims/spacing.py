"""How far apart agents fly, and whether that lasts."""

from __future__ import annotations

from posflock_robotarium.paper.claim import MOST, NEARLY_ALL, Claim, Result, Sense
from posflock_robotarium.paper.measurements import (
    P,
    V,
    distance_fluctuation,
    median,
    pairs_less,
    share,
)

CLAIMS: tuple[Claim, ...] = (
    Claim(
        "more-compact",
        "“results in more compact formations than a velocity-alignment-based baseline” (abstract)",
        "share of seeds at which the nearest neighbour is closer at the end in P-based (thr.)"
        " than in V-based",
        pairs_less("nearest_neighbour_end", P, V),
        Sense.AT_LEAST,
        NEARLY_ALL,
        MOST,
    ),
    Claim(
        "smaller-radius",
        "P-based (thr.): “a more compact … flocking configuration”, read as the cohesive radius",
        "share of seeds at which the cohesive radius is smaller at the end in P-based (thr.)"
        " than in V-based",
        pairs_less("cohesive_radius_end", P, V),
        Sense.AT_LEAST,
        NEARLY_ALL,
        MOST,
        reasons={
            Result.DOES_NOT_HOLD: "Neighbours are closer but the flock is wider: the imprint keeps"
            " the extent of the first square, which V-based flocks contract from.",
        },
    ),
    Claim(
        "separation-position",
        "P-based (thr.): inter-agent separations “typically 1.5–2 m”",
        "share of seeds whose mean nearest-neighbour distance for t > 20 s is 1.5 to 2 m",
        share(P, "nearest_neighbour_settled", 1.5, 2.0),
        Sense.AT_LEAST,
        0.75,
        0.5,
    ),
    Claim(
        "separation-velocity",
        "V-based: inter-agent separations of “2–3 m”",
        "share of seeds whose mean nearest-neighbour distance for t > 20 s is 2 to 3 m",
        share(V, "nearest_neighbour_settled", 2.0, 3.0),
        Sense.AT_LEAST,
        0.75,
        0.5,
    ),
    Claim(
        "steady-distances",
        "P-based (thr.): “minimal variation in distances over time”",
        "median over seeds of the relative deviation of the nearest-neighbour distance, t > 20 s",
        distance_fluctuation,
        Sense.AT_MOST,
        0.02,
        0.05,
    ),
    Claim(
        "constant-radius",
        "“the cohesion radius remains nearly constant”",
        "median over seeds of the largest over the smallest cohesive radius, t > 10 s,"
        " P-based (thr.)",
        median(P, "cohesive_radius_ratio"),
        Sense.AT_MOST,
        1.02,
        1.1,
    ),
)
