"""A sentence of the paper that can be checked, and what becomes of it.

A verdict is never written by hand.  A claim names one number, measured in the evidence,
and two thresholds declared beside the sentence: at or beyond the first the claim *holds*,
at or beyond the second it *holds weakly*, else it *does not hold*.  What is written by
hand is only why a result comes out as it does, and it is shown only with the verdict that
it explains.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np

from barrier_certificates import ties
from posflock_robotarium.paper.evidence import Evidence


class Result(Enum):
    """What becomes of a claim, in words; `mark` shows it at a glance."""

    HOLDS = "holds"
    HOLDS_WEAKLY = "holds weakly"
    DOES_NOT_HOLD = "does not hold"

    @property
    def mark(self) -> str:
        """A sign for tables."""
        return {
            Result.HOLDS: "✓",
            Result.HOLDS_WEAKLY: "~",
            Result.DOES_NOT_HOLD: "✗",
        }[self]


class Sense(Enum):
    """Which side of its thresholds a claim is on."""

    AT_LEAST = "at least"
    AT_MOST = "at most"


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
        Gives the number that is judged, in `unit`; NaN where it cannot be measured.
    sense : Sense
        Which side of the thresholds the paper claims.
    holds, weakly : float
        Thresholds, in `unit`: from the first on the claim holds, from the second on weakly.
    unit : str
        Of the number; empty for shares and cosines.
    reasons : mapping of Result to str
        Why, for the verdicts that need explaining.
    """

    id: str
    claim: str
    test: str
    measure: Callable[[Evidence], float]
    sense: Sense
    holds: float
    weakly: float
    unit: str = ""
    reasons: Mapping[Result, str] = field(default_factory=dict)

    def judge(self, evidence: Evidence) -> Judgement:
        """Measure, and compare with the thresholds.

        Parameters
        ----------
        evidence : Evidence
            Every run of the reproduction.
        """
        value = float(self.measure(evidence))
        return Judgement(self, value, self._verdict(value))

    def _verdict(self, value: float) -> Result:
        # A number that could not be measured (NaN) compares as false: nothing holds.
        sign = 1.0 if self.sense is Sense.AT_LEAST else -1.0
        if ties.reached(sign * value, sign * self.holds):
            return Result.HOLDS
        if ties.reached(sign * value, sign * self.weakly):
            return Result.HOLDS_WEAKLY
        return Result.DOES_NOT_HOLD


@dataclass(frozen=True)
class Judgement:
    """What became of a claim.

    Attributes
    ----------
    claim : Claim
        What the paper says.
    value : float
        What was measured, in the claim's unit.
    verdict : Result
        Whether it holds.
    """

    claim: Claim
    value: float
    verdict: Result

    @property
    def reason(self) -> str:
        """The comparison that made the verdict, and why where that is known."""
        claim, unit = self.claim, f" {self.claim.unit}" if self.claim.unit else ""
        compared = (
            f"Measured {self.value:.3g}{unit}; holds {claim.sense.value} {claim.holds:g}{unit},"
            f" weakly {claim.sense.value} {claim.weakly:g}{unit}."
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
                "sense": self.claim.sense.value,
                Result.HOLDS.value: self.claim.holds,
                Result.HOLDS_WEAKLY.value: self.claim.weakly,
            },
            "verdict": self.verdict.value,
            "reason": self.reason,
        }
