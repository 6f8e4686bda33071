"""What nine robots on wheels do in the arena."""

from __future__ import annotations

from posflock_robotarium.paper.claim import MOST, NEARLY_ALL, Claim, Sense
from posflock_robotarium.paper.measurements import (
    robots_consistent,
    robots_median,
    robots_safe,
)

CLAIMS: tuple[Claim, ...] = (
    Claim(
        "robots-align",
        "nine robots: “the establishment and maintenance of collective motion direction”",
        "median over seeds of the mean γ from motion for t > 20 s, nine robots, steered clear of"
        " walls (an addition to the paper)",
        robots_median("gamma_motion"),
        Sense.AT_LEAST,
        0.99,
        0.9,
    ),
    Claim(
        "robots-consistent",
        "“coherent flocking behavior was consistently observed” despite “actuation inaccuracies”",
        "share of seeds whose mean γ from motion for t > 20 s is 0.85 or more, with 10 % actuation"
        " noise and 1 mm tracking noise",
        robots_consistent,
        Sense.AT_LEAST,
        NEARLY_ALL,
        MOST,
    ),
    Claim(
        "robots-safe",
        "nine robots: velocities “conservatively saturated … to accommodate the compact arena”",
        "share of seeds without a collision and without a step outside the arena, ideal and noisy",
        robots_safe,
        Sense.AT_LEAST,
        NEARLY_ALL,
        MOST,
    ),
)
