"""What nine robots on wheels do in the arena."""

from __future__ import annotations

import numpy as np

from posflock_robotarium.paper.claim import Claim, Sense
from posflock_robotarium.paper.measurements import robots_median

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
        lambda evidence: float(np.mean(evidence.imperfect_robots.of("gamma_motion") >= 0.85)),
        Sense.AT_LEAST,
        1.0,
        0.9,
    ),
    Claim(
        "robots-safe",
        "nine robots: velocities “conservatively saturated … to accommodate the compact arena”",
        "collisions and steps outside the arena, all seeds, ideal and noisy",
        lambda evidence: float(
            sum(
                robots.of(name).sum()
                for robots in (evidence.robots, evidence.imperfect_robots)
                for name in ("collisions", "steps_outside")
            )
        ),
        Sense.AT_MOST,
        0.0,
        0.0,
    ),
)
