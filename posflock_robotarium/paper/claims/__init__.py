"""Sentences of the paper, each with a measurement and the thresholds that judge it.

One module holds what the paper says about one thing; a new claim is one entry in its module.
"""

from __future__ import annotations

from posflock_robotarium.paper.claim import Claim, Judgement
from posflock_robotarium.paper.claims import (
    alignment,
    beyond,
    nine_robots,
    persistence,
    spacing,
    two_agents,
)
from posflock_robotarium.paper.evidence import Evidence

CLAIMS: tuple[Claim, ...] = (
    *alignment.CLAIMS,
    *spacing.CLAIMS,
    *persistence.CLAIMS,
    *two_agents.CLAIMS,
    *beyond.CLAIMS,
    *nine_robots.CLAIMS,
)


def judge_all(evidence: Evidence) -> list[Judgement]:
    """Judge every claim, in the paper's order.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    return [claim.judge(evidence) for claim in CLAIMS]
