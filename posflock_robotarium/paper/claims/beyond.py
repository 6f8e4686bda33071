"""What the paper argues and does not measure: dimensions, size, noise, failures."""

from __future__ import annotations

from posflock_robotarium.paper.claim import Claim, Result, Sense
from posflock_robotarium.paper.evidence import Varied
from posflock_robotarium.paper.measurements import P, noise_advantage, settled_at

CLAIMS: tuple[Claim, ...] = (
    Claim(
        "three-dimensions",
        "agents in R^d, “d = {2, 3}”",
        "median over seeds of the mean γ for t > 20 s in three dimensions, P-based (thr.)",
        settled_at(Varied.THREE_DIMENSIONS, P, 3.0),
        Sense.AT_LEAST,
        0.99,
        0.95,
    ),
    Claim(
        "larger-teams",
        "“scales favorably to larger teams”",
        "median over seeds of the mean γ for t > 20 s, 100 agents at the same density,"
        " P-based (thr.)",
        settled_at(Varied.LARGER_TEAMS, P, 2.0),
        Sense.AT_LEAST,
        0.99,
        0.90,
        reasons={
            Result.HOLDS_WEAKLY: "More of the larger flocks settle into turning groups.  The time"
            " and the bandwidth that an agent needs do not grow.",
        },
    ),
    Claim(
        "noise-robustness",
        "the model “enhances robustness to noise” and suits swarms “where velocity measurements"
        " are unreliable, noisy”",
        "median over seeds of the least advantage in the mean γ for t > 20 s, of three levels of"
        " position noise (0.02, 0.05, 0.1 m), of P-based (thr.) over V-based that takes its"
        " velocities from equally noisy positions 0.2 s apart",
        noise_advantage,
        Sense.AT_LEAST,
        0.02,
        0.0,
    ),
    Claim(
        "dropout-tolerance",
        "“fault-tolerant alignment under sensing or communication failures”",
        "median over seeds of the mean γ for t > 20 s when each neighbour is missed at one step"
        " in ten, P-based (thr.)",
        settled_at(Varied.DROPOUT, P, 0.1),
        Sense.AT_LEAST,
        0.95,
        0.85,
        reasons={
            Result.DOES_NOT_HOLD: "A missed neighbour changes |N|, which multiplies every rest"
            " distance and the gain: dropout becomes a strong random force, which nothing"
            " averages.",
        },
    ),
    Claim(
        "agents-may-vanish",
        "“scalability, and fault tolerance” of position-based models",
        "median over seeds of the mean γ for t > 20 s of the survivors when a tenth of the agents"
        " vanishes at 30 s, P-based (thr.)",
        settled_at(Varied.VANISHING, P, 0.1),
        Sense.AT_LEAST,
        0.95,
        0.85,
    ),
    Claim(
        "agents-may-stop",
        "“scalability, and fault tolerance” of position-based models",
        "the same when one agent in fifty stops dead and is still sensed",
        settled_at(Varied.STOPPING, P, 0.02),
        Sense.AT_LEAST,
        0.95,
        0.85,
        reasons={
            Result.DOES_NOT_HOLD: "Nothing tells an agent that stopped from one that flocks, and"
            " the imprint ties its neighbours to it: one anchors fifty.",
        },
    ),
)
