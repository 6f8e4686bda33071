"""Whether the flock aligns, how fast, how well and for how long."""

from __future__ import annotations

from posflock_robotarium.paper.claim import MOST, NEARLY_ALL, Claim, Result, Sense
from posflock_robotarium.paper.measurements import (
    P,
    V,
    median,
    median_gain,
    pairs_less,
    peak_time,
    share,
)

CLAIMS: tuple[Claim, ...] = (
    Claim(
        "persistent-alignment",
        "“a position-based flocking model that achieves persistent velocity alignment without"
        " velocity sensing” (abstract)",
        "median over seeds of the mean γ for t > 20 s, P-based (thr.)",
        median(P, "gamma_settled"),
        Sense.AT_LEAST,
        0.99,
        0.95,
    ),
    Claim(
        "alignment-from-every-start",
        "“rapid convergence to near-maximal alignment (γ ≈ 1) within the transient phase, with"
        " this strong alignment sustained throughout the simulation”",
        "share of seeds whose mean γ for t > 20 s is 0.95 or more, P-based (thr.)",
        share(P, "gamma_settled", 0.95, 1.0),
        Sense.AT_LEAST,
        NEARLY_ALL,
        MOST,
        reasons={
            Result.HOLDS_WEAKLY: "A few starts settle into a slow, turning flock instead: where"
            " the drift is slow the saturation damps little.",
            Result.DOES_NOT_HOLD: "Starts whose drift is slow settle into a turning flock, which"
            " the saturation damps little.",
        },
    ),
    Claim(
        "faster-alignment",
        "“attains faster … directional alignment … than a velocity-alignment-based baseline”"
        " (abstract)",
        "share of seeds at which P-based (thr.) reaches γ = 0.9 before V-based",
        pairs_less("alignment_time", P, V),
        Sense.AT_LEAST,
        0.7,
        0.5,
    ),
    Claim(
        "stronger-alignment",
        "“The position-based approach achieves markedly stronger … alignment” (Table 2)",
        "median over seeds of the mean γ for t > 20 s, P-based (thr.) less V-based",
        median_gain,
        Sense.AT_LEAST,
        0.02,
        0.0,
        reasons={
            Result.HOLDS_WEAKLY: "The advantage is there; it is small, since both models come near"
            " γ = 1.",
        },
    ),
    Claim(
        "more-persistent-alignment",
        "“stronger, more persistent alignment” (conclusion); V-based “exhibits slight"
        " oscillations”",
        "share of seeds at which γ fluctuates less (deviation for t > 30 s) in P-based (thr.)"
        " than in V-based",
        pairs_less("gamma_fluctuation", P, V),
        Sense.AT_LEAST,
        0.7,
        0.5,
    ),
    Claim(
        "baseline-alignment",
        "V-based: “cohesive and coherent motion with relatively strong alignment”",
        "median over seeds of the mean γ for t > 20 s, V-based",
        median(V, "gamma_settled"),
        Sense.AT_LEAST,
        0.95,
        0.85,
    ),
    Claim(
        "baseline-peak",
        "V-based: “γ reaches a peak around t ≈ 30 s”",
        "median over seeds of the distance in time between the largest γ and 30 s",
        peak_time,
        Sense.AT_MOST,
        10.0,
        20.0,
        "s",
        reasons={
            Result.DOES_NOT_HOLD: "γ rises to a plateau on which the instant of its largest value"
            " is chance.",
        },
    ),
    Claim(
        "baseline-heading-varies",
        "V-based: “the collective direction continues to vary over time”",
        "median over seeds of the largest angle between two directions of the centroid,"
        " t > 20 s, V-based",
        median(V, "heading_spread"),
        Sense.AT_LEAST,
        45.0,
        15.0,
        "°",
    ),
    Claim(
        "persistent-direction",
        "P-based (thr.): “a clearly persistent collective direction throughout the simulation”",
        "the same angle, P-based (thr.)",
        median(P, "heading_spread"),
        Sense.AT_MOST,
        5.0,
        15.0,
        "°",
    ),
)
