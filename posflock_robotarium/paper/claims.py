"""Sentences of the paper, each with a measurement and the thresholds that judge it.

A verdict is never written by hand.  A claim names one number, measured in the evidence,
and two thresholds declared here beside the sentence: at or beyond the first the claim
*holds*, at or beyond the second it *holds weakly*, else it *does not hold*.  What is
written by hand is only why a result comes out as it does, and it is shown only with the
verdict that it explains.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.freespace import FreeSpace, Model, euler_step, simulate
from posflock_robotarium.law import (
    PAPER_SIMULATION,
    displacements,
    position_based_input,
    velocity_based_input,
)
from posflock_robotarium.paper.evidence import Evidence

Floats = NDArray[np.float64]
Verdict = Literal["holds", "holds weakly", "does not hold"]

V, P, N = Model.VELOCITY, Model.POSITION, Model.POSITION_NO_THRESHOLD


@dataclass(frozen=True)
class Claim:
    """A checkable sentence.

    Attributes
    ----------
    id : str
        Short name.
    claim : str
        The paper's words.
    test : str
        What is measured, in words.
    measure : function of Evidence
        The number.
    unit : str
        Of the number; empty for shares and cosines.
    sense : {"at least", "at most"}
        Which side of the thresholds the paper claims.
    holds, weakly : float
        The thresholds.
    reasons : dict of verdict to str
        Why, for the verdicts that need explaining.
    """

    id: str
    claim: str
    test: str
    measure: Callable[[Evidence], float]
    sense: Literal["at least", "at most"]
    holds: float
    weakly: float
    unit: str = ""
    reasons: Mapping[Verdict, str] = field(default_factory=dict)

    def judge(self, evidence: Evidence) -> Judgement:
        """Measure, and compare with the thresholds."""
        value = float(self.measure(evidence))
        return Judgement(self, value, self._verdict(value))

    def _verdict(self, value: float) -> Verdict:
        # A number that could not be measured (NaN) compares as false: nothing holds.
        sign = 1.0 if self.sense == "at least" else -1.0
        if sign * value >= sign * self.holds:
            return "holds"
        return "holds weakly" if sign * value >= sign * self.weakly else "does not hold"


@dataclass(frozen=True)
class Judgement:
    """What became of a claim."""

    claim: Claim
    value: float
    verdict: Verdict

    @property
    def reason(self) -> str:
        """The comparison that made the verdict, and why where that is known."""
        claim, unit = self.claim, f" {self.claim.unit}" if self.claim.unit else ""
        compared = (
            f"Measured {self.value:.3g}{unit}; holds {claim.sense} {claim.holds:g}{unit},"
            f" weakly {claim.sense} {claim.weakly:g}{unit}."
        )
        return " ".join([compared, claim.reasons.get(self.verdict, "")]).strip()

    def as_dict(self) -> dict[str, Any]:
        """Return the judgement for ``claims.json``; a value that is not finite becomes null."""
        return {
            "id": self.claim.id,
            "claim": self.claim.claim,
            "test": self.claim.test,
            "value": self.value if np.isfinite(self.value) else None,
            "unit": self.claim.unit,
            "thresholds": {
                "sense": self.claim.sense,
                "holds": self.claim.holds,
                "holds weakly": self.claim.weakly,
            },
            "verdict": self.verdict,
            "reason": self.reason,
        }


def judge_all(evidence: Evidence) -> list[Judgement]:
    """Judge every claim, in the paper's order."""
    return [claim.judge(evidence) for claim in CLAIMS]


# ---------------------------------------------------------------- what is measured


def _median(model: Model, name: str) -> Callable[[Evidence], float]:
    return lambda evidence: float(np.median(evidence.numbers(model)[name]))


def _share(model: Model, name: str, low: float, high: float) -> Callable[[Evidence], float]:
    def share(evidence: Evidence) -> float:
        values = evidence.numbers(model)[name]
        return float(np.mean((values >= low) & (values <= high)))

    return share


def _pairs_less(name: str, less: Model, more: Model) -> Callable[[Evidence], float]:
    """Share of seeds at which one model's number is less than the other's."""
    return lambda evidence: float(
        np.mean(evidence.numbers(less)[name] < evidence.numbers(more)[name])
    )


def _median_gain(evidence: Evidence) -> float:
    name = "gamma_settled"
    return float(np.median(evidence.numbers(P)[name] - evidence.numbers(V)[name]))


def _distance_fluctuation(evidence: Evidence) -> float:
    """Median over seeds of the relative deviation of the nearest-neighbour distance, t > 20 s."""
    measures = evidence.measures[P]
    distance = measures.nearest_neighbour[:, measures.times >= 20.0]
    return float(np.median(distance.std(axis=-1) / distance.mean(axis=-1)))


def _peak_time(evidence: Evidence) -> float:
    """How far from 30 s the V-based γ is largest, median over seeds."""
    measures = evidence.measures[V]
    peak = measures.times[np.nanargmax(measures.gamma, axis=-1)]
    return float(np.median(np.abs(peak - 30.0)))


def _early_difference(evidence: Evidence) -> float:
    """Largest difference of γ between the two P-based models until t = 1/k."""
    early = evidence.measures[P].times <= 1.0 / PAPER_SIMULATION.persistence
    with_, without = (evidence.measures[model].gamma[:, early] for model in (P, N))
    return float(np.max(np.abs(with_ - without)))


def _transient_variance_change(evidence: Evidence) -> float:
    measures = evidence.measures[P]
    settled = int(np.argmin(np.abs(measures.times - 10.0)))
    variance = measures.distance_variance
    return float(np.median(variance[:, settled] - variance[:, 0]))


def _transient_change_variance(evidence: Evidence) -> float:
    measures = evidence.measures[P]
    settled = int(np.argmin(np.abs(measures.times - 10.0)))
    return float(np.median(measures.change_variance[:, settled]))


def _denser_with_smaller_scale(evidence: Evidence) -> float:
    """Share of steps of δ at which the nearest-neighbour distance grows, P and V."""
    grows: list[bool] = []
    for model in (V, P):
        _, numbers = evidence.study("distance scale δ", model)
        distance = [np.median(each["nearest_neighbour_settled"]) for each in numbers]
        grows.extend(np.diff(distance) > 0.0)
    return float(np.mean(grows))


def _pair_at_rest(_: Evidence) -> float:
    """How far from δ·|N| = δ two V-based agents come to rest, metres."""
    scenario = FreeSpace(model=V, agents=2, side=1.0, fastest_start=0.1, duration=60.0)
    last = simulate(scenario, seed=0).positions[-1]
    delta = float(np.max(scenario.law.distance_scale))
    return float(abs(np.sqrt(np.square(last[:, 1] - last[:, 0]).sum()) - delta))


def _head_on_passes(_: Evidence) -> float:
    """Share of head-on meetings of two agents that end in passing through each other."""
    meetings = product((V, P), (0.5, 1.0, 2.0), (0.1, 0.25, 0.5, 1.0), (0.5, 1.0, 1.5, 2.0, 2.5))
    return float(np.mean([_passes_through(*meeting) for meeting in meetings]))


def _passes_through(model: Model, distance: float, delta: float, speed: float) -> bool:
    """Let two agents at some distance drive at each other; tell whether they change sides."""
    law = replace(PAPER_SIMULATION, distance_scale=delta)
    positions = np.array([[0.0, distance], [0.0, 0.0]])
    velocities = np.array([[speed, -speed], [0.0, 0.0]])
    imprint, time_step = displacements(positions), 0.05
    for step in range(1, 101):
        inputs = (
            velocity_based_input(positions, velocities, law)
            if model is V
            else position_based_input(positions, imprint, step * time_step, law)
        )
        positions, velocities = euler_step(positions, velocities, inputs, time_step, law)
        if positions[0, 0] >= positions[0, 1]:
            return True
    return False


def _settled_at(study: str, model: Model, value: float) -> Callable[[Evidence], float]:
    return lambda evidence: float(np.median(evidence.at(study, model, value)["gamma_settled"]))


def _noise_advantage(evidence: Evidence) -> float:
    """Least advantage in γ of P over V that differentiates the same noisy positions."""
    return float(
        min(
            np.median(evidence.at("position noise", P, noise)["gamma_settled"])
            - np.median(evidence.at("differentiated noise", V, noise)["gamma_settled"])
            for noise in (0.02, 0.05, 0.1)
        )
    )


def _robots_median(name: str) -> Callable[[Evidence], float]:
    return lambda evidence: float(np.median(evidence.robots.of(name)))


# ---------------------------------------------------------------- what is claimed

CLAIMS: tuple[Claim, ...] = (
    Claim(
        "persistent-alignment",
        "“a position-based flocking model that achieves persistent velocity alignment without"
        " velocity sensing” (abstract)",
        "median over seeds of the mean γ for t > 20 s, P-based (thr.)",
        _median(P, "gamma_settled"),
        "at least",
        0.99,
        0.95,
    ),
    Claim(
        "alignment-from-every-start",
        "“rapid convergence to near-maximal alignment (γ ≈ 1) within the transient phase, with"
        " this strong alignment sustained throughout the simulation”",
        "share of seeds whose mean γ for t > 20 s is 0.95 or more, P-based (thr.)",
        _share(P, "gamma_settled", 0.95, 1.0),
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
        _pairs_less("alignment_time", P, V),
        "at least",
        0.7,
        0.5,
    ),
    Claim(
        "stronger-alignment",
        "“The position-based approach achieves markedly stronger … alignment” (Table 2)",
        "median over seeds of the mean γ for t > 20 s, P-based (thr.) less V-based",
        _median_gain,
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
        _pairs_less("gamma_fluctuation", P, V),
        "at least",
        0.7,
        0.5,
    ),
    Claim(
        "baseline-alignment",
        "V-based: “cohesive and coherent motion with relatively strong alignment”",
        "median over seeds of the mean γ for t > 20 s, V-based",
        _median(V, "gamma_settled"),
        "at least",
        0.95,
        0.85,
    ),
    Claim(
        "baseline-peak",
        "V-based: “γ reaches a peak around t ≈ 30 s”",
        "median over seeds of the distance in time between the largest γ and 30 s",
        _peak_time,
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
        _median(V, "heading_spread"),
        "at least",
        45.0,
        15.0,
        "°",
    ),
    Claim(
        "persistent-direction",
        "P-based (thr.): “a clearly persistent collective direction throughout the simulation”",
        "the same angle, P-based (thr.)",
        _median(P, "heading_spread"),
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
        _pairs_less("nearest_neighbour_end", P, V),
        "at least",
        0.95,
        0.75,
    ),
    Claim(
        "smaller-radius",
        "P-based (thr.): “a more compact … flocking configuration”, read as the cohesive radius",
        "share of seeds at which the cohesive radius is smaller at the end in P-based (thr.)"
        " than in V-based",
        _pairs_less("cohesive_radius_end", P, V),
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
        _share(P, "nearest_neighbour_settled", 1.5, 2.0),
        "at least",
        0.75,
        0.5,
    ),
    Claim(
        "separation-velocity",
        "V-based: inter-agent separations of “2–3 m”",
        "share of seeds whose mean nearest-neighbour distance for t > 20 s is 2 to 3 m",
        _share(V, "nearest_neighbour_settled", 2.0, 3.0),
        "at least",
        0.75,
        0.5,
    ),
    Claim(
        "steady-distances",
        "P-based (thr.): “minimal variation in distances over time”",
        "median over seeds of the relative deviation of the nearest-neighbour distance, t > 20 s",
        _distance_fluctuation,
        "at most",
        0.02,
        0.05,
    ),
    Claim(
        "constant-radius",
        "“the cohesion radius remains nearly constant”",
        "median over seeds of the largest over the smallest cohesive radius, t > 10 s,"
        " P-based (thr.)",
        _median(P, "cohesive_radius_ratio"),
        "at most",
        1.02,
        1.1,
    ),
    Claim(
        "no-threshold-starts-alike",
        "P-based (no thr.): “initially display strong alignment and persistent direction similar"
        " to the threshold case”",
        "largest difference of γ between the P-based models up to t = 1/k, over all seeds",
        _early_difference,
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
        _median(N, "gamma_change"),
        "at most",
        -0.10,
        -0.03,
    ),
    Claim(
        "threshold-essential",
        "“the non-vanishing threshold is essential for maintaining persistent collective"
        " alignment”",
        "share of seeds whose mean γ for t > 20 s is lower without the threshold than with it",
        _pairs_less("gamma_settled", N, P),
        "at least",
        0.95,
        0.75,
    ),
    Claim(
        "no-threshold-coheres",
        "P-based (no thr.): loss of directional coherence “while spatial cohesion is largely"
        " maintained”",
        "share of seeds that end as one connected group, P-based (no thr.)",
        _share(N, "components_end", 1.0, 1.0),
        "at least",
        0.95,
        0.75,
    ),
    Claim(
        "variance-increases",
        "“this variance [of pairwise distances] increases during the transient phase” (Fig. 6)",
        "median over seeds of the variance of pairwise distances at 10 s less that at 0 s,"
        " P-based (thr.)",
        _transient_variance_change,
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
        _transient_change_variance,
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
        _head_on_passes,
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
        _pair_at_rest,
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
        _denser_with_smaller_scale,
        "at least",
        1.0,
        0.8,
    ),
    Claim(
        "three-dimensions",
        "agents in R^d, “d = {2, 3}”",
        "median over seeds of the mean γ for t > 20 s in three dimensions, P-based (thr.)",
        _settled_at("three dimensions", P, 3.0),
        "at least",
        0.99,
        0.95,
    ),
    Claim(
        "larger-teams",
        "“scales favorably to larger teams”",
        "median over seeds of the mean γ for t > 20 s, 100 agents at the same density,"
        " P-based (thr.)",
        _settled_at("times as many agents", P, 2.0),
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
        _noise_advantage,
        "at least",
        0.02,
        0.0,
    ),
    Claim(
        "dropout-tolerance",
        "“fault-tolerant alignment under sensing or communication failures”",
        "median over seeds of the mean γ for t > 20 s when each neighbour is missed at one step"
        " in ten, P-based (thr.)",
        _settled_at("dropout", P, 0.1),
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
        _settled_at("vanishing agents", P, 0.1),
        "at least",
        0.95,
        0.85,
    ),
    Claim(
        "agents-may-stop",
        "“scalability, and fault tolerance” of position-based models",
        "the same when one agent in fifty stops dead and is still sensed",
        _settled_at("stopping agents", P, 0.02),
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
        _robots_median("gamma_motion"),
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
