"""A sentence of the paper that can be checked, and what becomes of it.

A verdict is never written by hand.  A claim names one number, measured in the evidence, and two
thresholds declared beside the sentence.  A number over seeds comes with its 95 % interval, and
other seeds would give another number in it, so that the interval is judged and not the number:

=============  ==============================================================================
holds          the whole interval is at or beyond the first threshold
holds weakly   the whole interval is at or beyond the second one: weakly at least.  Whether it
               reaches beyond the first, so that more seeds could show more, is said beside it
does not hold  the whole interval is before the second one
not settled    the second one is within the interval: these seeds do not tell; nor do fewer
               than three, of which there is no interval
=============  ==============================================================================

A number that no seed changes is its own interval, and is always settled.  What is written by hand
is only why a result comes out as it does, and it is shown only with the verdict that it explains.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np

from barrier_certificates import ties
from posflock_robotarium.paper.evidence import Evidence
from posflock_robotarium.paper.measured import Measured

#: Thresholds of shares over seeds where the paper speaks of every flock: 95 in 100 do it, 75 do.
NEARLY_ALL, MOST = 0.95, 0.75


class Result(Enum):
    """What becomes of a claim, in words; `mark` shows it at a glance."""

    HOLDS = "holds"
    HOLDS_WEAKLY = "holds weakly"
    NOT_SETTLED = "not settled"
    DOES_NOT_HOLD = "does not hold"

    @property
    def mark(self) -> str:
        """A sign for tables."""
        return {
            Result.HOLDS: "✓",
            Result.HOLDS_WEAKLY: "~",
            Result.NOT_SETTLED: "?",
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
        Gives the number that is judged, in `unit`, with its interval.
    sense : Sense
        Which side of the thresholds the paper claims.
    holds, weakly : float
        Thresholds, in `unit`: what is at or beyond the first holds, beyond the second weakly.
    unit : str
        Of the number; empty for shares and cosines.
    reasons : mapping of Result to str
        Why, for the verdicts that need explaining.
    """

    id: str
    claim: str
    test: str
    measure: Callable[[Evidence], Measured]
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
        measured = self.measure(evidence)
        return Judgement(self, measured, self._verdict(measured))

    def _verdict(self, measured: Measured) -> Result:
        if measured.interval is None:
            return Result.NOT_SETTLED
        worst, best = self._ends(measured.interval)
        if ties.reached(worst, self._sign * self.holds):
            return Result.HOLDS
        if ties.reached(worst, self._sign * self.weakly):
            return Result.HOLDS_WEAKLY
        # A number that could not be measured (NaN) compares as false: nothing holds.
        within = ties.reached(best, self._sign * self.weakly)
        return Result.NOT_SETTLED if within else Result.DOES_NOT_HOLD

    def could_hold(self, measured: Measured) -> bool:
        """Return whether the best end of the interval is at or beyond the first threshold.

        Parameters
        ----------
        measured : Measured
            A number in the claim's unit.
        """
        if measured.interval is None:
            return True
        return bool(ties.reached(self._ends(measured.interval)[1], self._sign * self.holds))

    @property
    def _sign(self) -> float:
        return 1.0 if self.sense is Sense.AT_LEAST else -1.0

    def _ends(self, interval: tuple[float, float]) -> tuple[float, float]:
        """Return the ends for and against the claim, more being better: the worst and the best."""
        low, high = interval
        return (low, high) if self.sense is Sense.AT_LEAST else (-high, -low)


@dataclass(frozen=True)
class Judgement:
    """What became of a claim.

    Attributes
    ----------
    claim : Claim
        What the paper says.
    measured : Measured
        The number, in the claim's unit, with its interval.
    verdict : Result
        Whether it holds.
    """

    claim: Claim
    measured: Measured
    verdict: Result

    @property
    def value(self) -> float:
        """What was measured, in the claim's unit."""
        return self.measured.value

    @property
    def reason(self) -> str:
        """The comparison that made the verdict, and why where that is known."""
        claim, unit = self.claim, f" {self.claim.unit}" if self.claim.unit else ""
        compared = (
            f"Measured {self._number}; holds {claim.sense.value} {claim.holds:g}{unit},"
            f" weakly {claim.sense.value} {claim.weakly:g}{unit}."
        )
        sentences = [compared, self._open, claim.reasons.get(self.verdict, "")]
        return " ".join(sentence for sentence in sentences if sentence)

    @property
    def _number(self) -> str:
        measured, unit = self.measured, f" {self.claim.unit}" if self.claim.unit else ""
        value = f"{measured.value:.3g}{unit}"
        if measured.runs is None:
            return value
        if measured.interval is None:
            return f"{value} over {measured.runs} seeds, which tell no interval"
        low, high = measured.interval
        return f"{value} over {measured.runs} seeds, 95 % interval {low:.3g} to {high:.3g}{unit}"

    @property
    def _open(self) -> str:
        """What the interval leaves open, in words."""
        if self.verdict is Result.NOT_SETTLED:
            return "These seeds do not settle it." if self.measured.interval else ""
        if self.verdict is Result.HOLDS_WEAKLY and self.claim.could_hold(self.measured):
            return "It holds weakly at least; whether it holds in full these seeds do not settle."
        return ""

    def as_dict(self) -> dict[str, Any]:
        """Return the judgement for ``claims.json``; a number that is not finite becomes null."""
        ends = self.measured.interval
        return {
            "id": self.claim.id,
            "claim": self.claim.claim,
            "test": self.claim.test,
            "value": _finite(self.measured.value),
            "interval": None if ends is None else [_finite(end) for end in ends],
            "runs": self.measured.runs,
            "unit": self.claim.unit,
            "thresholds": {
                "sense": self.claim.sense.value,
                Result.HOLDS.value: self.claim.holds,
                Result.HOLDS_WEAKLY.value: self.claim.weakly,
            },
            "verdict": self.verdict.value,
            "reason": self.reason,
        }


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
