"""What the law itself promises: no collision, a rest distance, a density."""

from __future__ import annotations

from posflock_robotarium.paper.claim import MOST, NEARLY_ALL, Claim, Result, Sense
from posflock_robotarium.paper.measurements import (
    denser_with_smaller_scale,
    head_on_passes,
    pair_at_rest,
)

CLAIMS: tuple[Claim, ...] = (
    Claim(
        "no-collisions",
        "“Short-range repulsion inherently prevents collisions for any finite δ > 0”",
        "share of 120 head-on meetings of two agents (from 0.5 to 2 m apart, δ from 0.1 to 1 m,"
        " each at 0.5 to 2.5 m/s) in which they pass through each other",
        head_on_passes,
        Sense.AT_MOST,
        0.0,
        0.05,
        reasons={
            Result.DOES_NOT_HOLD: "The repulsion is bounded by δ·|N| (and by u_max), so that fast"
            " agents with a small δ cross its whole range. Real robots need a certificate.",
        },
    ),
    Claim(
        "rest-distance",
        "“ψ = 0 at ‖p_j − p_i‖ = δ_i|N_i| marks equilibrium spacing”",
        "how far from δ|N| two V-based agents come to rest",
        pair_at_rest,
        Sense.AT_MOST,
        0.01,
        0.05,
        "m",
    ),
    Claim(
        "scale-tunes-density",
        "“smaller δ_i yields compact flocks …, while larger δ_i produces looser flocks”",
        "share of seeds at which the mean nearest-neighbour distance for t > 20 s grows at every"
        " step of δ from 0.3 to 0.8 m, V-based and P-based (thr.)",
        denser_with_smaller_scale,
        Sense.AT_LEAST,
        NEARLY_ALL,
        MOST,
    ),
)
