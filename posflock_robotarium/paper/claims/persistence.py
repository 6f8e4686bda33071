"""What the threshold of the gain keeps, and what is left of the first formation."""

from __future__ import annotations

from posflock_robotarium.paper.claim import MOST, NEARLY_ALL, Claim, Result, Sense
from posflock_robotarium.paper.measurements import (
    N,
    P,
    equal_at_first,
    imprint_left,
    median,
    pairs_less,
    share,
    transient_change_variance,
    transient_variance_change,
)

CLAIMS: tuple[Claim, ...] = (
    Claim(
        "no-threshold-starts-alike",
        "P-based (no thr.): “initially display strong alignment and persistent direction similar"
        " to the threshold case”",
        "share of seeds at which both P-based models have the same γ up to t = 1/k",
        equal_at_first,
        Sense.AT_LEAST,
        NEARLY_ALL,
        MOST,
        reasons={Result.HOLDS: "Until t = 1/k the two laws are one."},
    ),
    Claim(
        "no-threshold-decays",
        "P-based (no thr.): “over an extended time, the alignment gradually weakens as the gain"
        " decays”",
        "median over seeds of mean γ on [80, 100] s less mean γ on [10, 30] s, P-based (no thr.)",
        median(N, "gamma_change"),
        Sense.AT_MOST,
        -0.10,
        -0.03,
    ),
    Claim(
        "threshold-essential",
        "“the non-vanishing threshold is essential for maintaining persistent collective"
        " alignment”",
        "share of seeds whose mean γ for t > 20 s is lower without the threshold than with it",
        pairs_less("gamma_settled", N, P),
        Sense.AT_LEAST,
        NEARLY_ALL,
        MOST,
    ),
    Claim(
        "no-threshold-coheres",
        "P-based (no thr.): loss of directional coherence “while spatial cohesion is largely"
        " maintained”",
        "share of seeds that end as one connected group, P-based (no thr.)",
        share(N, "components_end", 1.0, 1.0),
        Sense.AT_LEAST,
        NEARLY_ALL,
        MOST,
    ),
    Claim(
        "variance-increases",
        "“this variance [of pairwise distances] increases during the transient phase” (Fig. 6)",
        "median over seeds of the variance of pairwise distances at 10 s less that at 0 s,"
        " P-based (thr.)",
        transient_variance_change,
        Sense.AT_LEAST,
        1.0,
        0.0,
        "m²",
        reasons={
            Result.DOES_NOT_HOLD: "It falls: cohesion draws the corners of the first square in."
            " What rises and then stays is the variance of the change of pairwise distances.",
        },
    ),
    Claim(
        "formation-not-preserved",
        "“the initial formation is not preserved” (caption of Fig. 6)",
        "median over seeds of the variance of the change of pairwise distances at 10 s,"
        " P-based (thr.)",
        transient_change_variance,
        Sense.AT_LEAST,
        0.5,
        0.1,
        "m²",
    ),
    Claim(
        "imprint-fades",
        "“the initial configuration acts as a weak, transient memory imprint that gradually loses"
        " its influence”",
        "median over seeds of the imprint's mean pull ‖φ_i·Σ_j p_ij(0)‖ at 100 s, as a share of"
        " that at 10 s, P-based (thr.)",
        imprint_left,
        Sense.AT_MOST,
        0.1,
        0.5,
        reasons={
            Result.DOES_NOT_HOLD: "The threshold that keeps the alignment also keeps the weight of"
            " the imprint, at k·|N| for ever; it fades only without the threshold.",
        },
    ),
)
