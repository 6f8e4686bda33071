"""Sentences of the paper, each with a measurement and the thresholds that judge it."""

from __future__ import annotations

import numpy as np

from posflock_robotarium.paper.claim import Claim, Judgement
from posflock_robotarium.paper.evidence import Evidence
from posflock_robotarium.paper.measurements import (
    N,
    P,
    V,
    denser_with_smaller_scale,
    distance_fluctuation,
    early_difference,
    head_on_passes,
    median,
    median_gain,
    noise_advantage,
    pair_at_rest,
    pairs_less,
    peak_time,
    robots_median,
    settled_at,
    share,
    transient_change_variance,
    transient_variance_change,
)

CLAIMS: tuple[Claim, ...] = (
    Claim(
        "persistent-alignment",
        "“a position-based flocking model that achieves persistent velocity alignment without"
        " velocity sensing” (abstract)",
        "median over seeds of the mean γ for t > 20 s, P-based (thr.)",
        median(P, "gamma_settled"),
        "at least",
        0.99,
        0.95,
    ),
    Claim(
        "alignment-from-every-start",
        "“rapid convergence to near-maximal alignment (γ ≈ 1) within the transient phase, with"
        " this strong alignment sustained throughout the simulation”",
        "share of seeds whose mean γ for t > 20 s is 0.95 or more, P-based (thr.)",
        share(P, "gamma_settled", 0.95, 1.0),
        "at least",
        1.0,
        0.9,
        reasons={
            "holds weakly": "A few starts settle into a slow, turning flock instead: where the"
            " drift is slow the saturation damps little.",
            "does not hold": "Starts whose drift is slow settle into a turning flock, which the"
            " saturation damps little.",
        },
    ),
    Claim(
        "faster-alignment",
        "“attains faster … directional alignment … than a velocity-alignment-based baseline”"
        " (abstract)",
        "share of seeds at which P-based (thr.) reaches γ = 0.9 before V-based",
        pairs_less("alignment_time", P, V),
        "at least",
        0.7,
        0.5,
    ),
    Claim(
        "stronger-alignment",
        "“The position-based approach achieves markedly stronger … alignment” (Table 2)",
        "median over seeds of the mean γ for t > 20 s, P-based (thr.) less V-based",
        median_gain,
        "at least",
        0.02,
        0.0,
        reasons={
            "holds weakly": "The advantage is there, but too small to be called marked: both"
            " models come near γ = 1.",
        },
    ),
    Claim(
        "more-persistent-alignment",
        "“stronger, more persistent alignment” (conclusion); V-based “exhibits slight"
        " oscillations”",
        "share of seeds at which γ fluctuates less (deviation for t > 30 s) in P-based (thr.)"
        " than in V-based",
        pairs_less("gamma_fluctuation", P, V),
        "at least",
        0.7,
        0.5,
    ),
    Claim(
        "baseline-alignment",
        "V-based: “cohesive and coherent motion with relatively strong alignment”",
        "median over seeds of the mean γ for t > 20 s, V-based",
        median(V, "gamma_settled"),
        "at least",
        0.95,
        0.85,
    ),
    Claim(
        "baseline-peak",
        "V-based: “γ reaches a peak around t ≈ 30 s”",
        "median over seeds of the distance in time between the largest γ and 30 s",
        peak_time,
        "at most",
        10.0,
        20.0,
        "s",
        reasons={
            "does not hold": "γ rises to a plateau on which the instant of its largest value is"
            " chance.",
        },
    ),
    Claim(
        "baseline-heading-varies",
        "V-based: “the collective direction continues to vary over time”",
        "median over seeds of the largest angle between two directions of the centroid,"
        " t > 20 s, V-based",
        median(V, "heading_spread"),
        "at least",
        45.0,
        15.0,
        "°",
    ),
    Claim(
        "persistent-direction",
        "P-based (thr.): “a clearly persistent collective direction throughout the simulation”",
        "the same angle, P-based (thr.)",
        median(P, "heading_spread"),
        "at most",
        5.0,
        15.0,
        "°",
    ),
    Claim(
        "more-compact",
        "“results in more compact formations than a velocity-alignment-based baseline” (abstract)",
        "share of seeds at which the nearest neighbour is closer at the end in P-based (thr.)"
        " than in V-based",
        pairs_less("nearest_neighbour_end", P, V),
        "at least",
        0.95,
        0.75,
    ),
    Claim(
        "smaller-radius",
        "P-based (thr.): “a more compact … flocking configuration”, read as the cohesive radius",
        "share of seeds at which the cohesive radius is smaller at the end in P-based (thr.)"
        " than in V-based",
        pairs_less("cohesive_radius_end", P, V),
        "at least",
        0.95,
        0.75,
        reasons={
            "does not hold": "Neighbours are closer but the flock is wider: the imprint keeps the"
            " extent of the first square, which V-based flocks contract from.",
        },
    ),
    Claim(
        "separation-position",
        "P-based (thr.): inter-agent separations “typically 1.5–2 m”",
        "share of seeds whose mean nearest-neighbour distance for t > 20 s is 1.5 to 2 m",
        share(P, "nearest_neighbour_settled", 1.5, 2.0),
        "at least",
        0.75,
        0.5,
    ),
    Claim(
        "separation-velocity",
        "V-based: inter-agent separations of “2–3 m”",
        "share of seeds whose mean nearest-neighbour distance for t > 20 s is 2 to 3 m",
        share(V, "nearest_neighbour_settled", 2.0, 3.0),
        "at least",
        0.75,
        0.5,
    ),
    Claim(
        "steady-distances",
        "P-based (thr.): “minimal variation in distances over time”",
        "median over seeds of the relative deviation of the nearest-neighbour distance, t > 20 s",
        distance_fluctuation,
        "at most",
        0.02,
        0.05,
    ),
    Claim(
        "constant-radius",
        "“the cohesion radius remains nearly constant”",
        "median over seeds of the largest over the smallest cohesive radius, t > 10 s,"
        " P-based (thr.)",
        median(P, "cohesive_radius_ratio"),
        "at most",
        1.02,
        1.1,
    ),
    Claim(
        "no-threshold-starts-alike",
        "P-based (no thr.): “initially display strong alignment and persistent direction similar"
        " to the threshold case”",
        "largest difference of γ between the P-based models up to t = 1/k, over all seeds",
        early_difference,
        "at most",
        1e-9,
        0.05,
        reasons={"holds": "Until t = 1/k the two laws are one."},
    ),
    Claim(
        "no-threshold-decays",
        "P-based (no thr.): “over an extended time, the alignment gradually weakens as the gain"
        " decays”",
        "median over seeds of mean γ on [80, 100] s less mean γ on [10, 30] s, P-based (no thr.)",
        median(N, "gamma_change"),
        "at most",
        -0.10,
        -0.03,
    ),
    Claim(
        "threshold-essential",
        "“the non-vanishing threshold is essential for maintaining persistent collective"
        " alignment”",
        "share of seeds whose mean γ for t > 20 s is lower without the threshold than with it",
        pairs_less("gamma_settled", N, P),
        "at least",
        0.95,
        0.75,
    ),
    Claim(
        "no-threshold-coheres",
        "P-based (no thr.): loss of directional coherence “while spatial cohesion is largely"
        " maintained”",
        "share of seeds that end as one connected group, P-based (no thr.)",
        share(N, "components_end", 1.0, 1.0),
        "at least",
        0.95,
        0.75,
    ),
    Claim(
        "variance-increases",
        "“this variance [of pairwise distances] increases during the transient phase” (Fig. 6)",
        "median over seeds of the variance of pairwise distances at 10 s less that at 0 s,"
        " P-based (thr.)",
        transient_variance_change,
        "at least",
        1.0,
        0.0,
        "m²",
        reasons={
            "does not hold": "It falls: cohesion draws the corners of the first square in. What"
            " rises and then stays is the variance of the change of pairwise distances.",
        },
    ),
    Claim(
        "formation-not-preserved",
        "“the initial formation is not preserved” (caption of Fig. 6)",
        "median over seeds of the variance of the change of pairwise distances at 10 s,"
        " P-based (thr.)",
        transient_change_variance,
        "at least",
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
        lambda evidence: float(np.median(evidence.imprint[P])),
        "at most",
        0.1,
        0.5,
        reasons={
            "does not hold": "The threshold that keeps the alignment also keeps the weight of the"
            " imprint, at k·|N| for ever; it fades only without the threshold.",
        },
    ),
    Claim(
        "no-collisions",
        "“Short-range repulsion inherently prevents collisions for any finite δ > 0”",
        "share of 120 head-on meetings of two agents (from 0.5 to 2 m apart, δ from 0.1 to 1 m,"
        " each at 0.5 to 2.5 m/s) in which they pass through each other",
        head_on_passes,
        "at most",
        0.0,
        0.05,
        reasons={
            "does not hold": "The repulsion is bounded by δ·|N| (and by u_max), so that fast"
            " agents with a small δ cross its whole range. Real robots need a certificate.",
        },
    ),
    Claim(
        "rest-distance",
        "“ψ = 0 at ‖p_j − p_i‖ = δ_i|N_i| marks equilibrium spacing”",
        "how far from δ|N| two V-based agents come to rest",
        pair_at_rest,
        "at most",
        0.01,
        0.05,
        "m",
    ),
    Claim(
        "scale-tunes-density",
        "“smaller δ_i yields compact flocks …, while larger δ_i produces looser flocks”",
        "share of steps of δ from 0.3 to 0.8 m at which the median nearest-neighbour distance"
        " grows, V-based and P-based (thr.)",
        denser_with_smaller_scale,
        "at least",
        1.0,
        0.8,
    ),
    Claim(
        "three-dimensions",
        "agents in R^d, “d = {2, 3}”",
        "median over seeds of the mean γ for t > 20 s in three dimensions, P-based (thr.)",
        settled_at("three dimensions", P, 3.0),
        "at least",
        0.99,
        0.95,
    ),
    Claim(
        "larger-teams",
        "“scales favorably to larger teams”",
        "median over seeds of the mean γ for t > 20 s, 100 agents at the same density,"
        " P-based (thr.)",
        settled_at("times as many agents", P, 2.0),
        "at least",
        0.99,
        0.90,
        reasons={
            "holds weakly": "More of the larger flocks settle into turning groups.  The time and"
            " the bandwidth that an agent needs do not grow.",
        },
    ),
    Claim(
        "noise-robustness",
        "the model “enhances robustness to noise” and suits swarms “where velocity measurements"
        " are unreliable, noisy”",
        "least advantage in median γ of P-based (thr.) over V-based that takes its velocities from"
        " positions 0.2 s apart, both with position noise of 0.02, 0.05 and 0.1 m",
        noise_advantage,
        "at least",
        0.02,
        0.0,
    ),
    Claim(
        "dropout-tolerance",
        "“fault-tolerant alignment under sensing or communication failures”",
        "median over seeds of the mean γ for t > 20 s when each neighbour is missed at one step"
        " in ten, P-based (thr.)",
        settled_at("dropout", P, 0.1),
        "at least",
        0.95,
        0.85,
        reasons={
            "does not hold": "A missed neighbour changes |N|, which multiplies every rest distance"
            " and the gain: dropout becomes a strong random force, which nothing averages.",
        },
    ),
    Claim(
        "agents-may-vanish",
        "“scalability, and fault tolerance” of position-based models",
        "median over seeds of the mean γ for t > 20 s of the survivors when a tenth of the agents"
        " vanishes at 30 s, P-based (thr.)",
        settled_at("vanishing agents", P, 0.1),
        "at least",
        0.95,
        0.85,
    ),
    Claim(
        "agents-may-stop",
        "“scalability, and fault tolerance” of position-based models",
        "the same when one agent in fifty stops dead and is still sensed",
        settled_at("stopping agents", P, 0.02),
        "at least",
        0.95,
        0.85,
        reasons={
            "does not hold": "Nothing tells an agent that stopped from one that flocks, and the"
            " imprint ties its neighbours to it: one anchors fifty.",
        },
    ),
    Claim(
        "robots-align",
        "nine robots: “the establishment and maintenance of collective motion direction”",
        "median over seeds of the mean γ from motion for t > 20 s, nine robots, steered clear of"
        " walls (an addition to the paper)",
        robots_median("gamma_motion"),
        "at least",
        0.99,
        0.9,
    ),
    Claim(
        "robots-consistent",
        "“coherent flocking behavior was consistently observed” despite “actuation inaccuracies”",
        "share of seeds whose mean γ from motion for t > 20 s is 0.85 or more, with 10 % actuation"
        " noise and 1 mm tracking noise",
        lambda evidence: float(np.mean(evidence.imperfect_robots.of("gamma_motion") >= 0.85)),
        "at least",
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
        "at most",
        0.0,
        0.0,
    ),
)


def judge_all(evidence: Evidence) -> list[Judgement]:
    """Judge every claim, in the paper's order.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    return [claim.judge(evidence) for claim in CLAIMS]
