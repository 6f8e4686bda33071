"""What a batch certificate did, team by team."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from barrier_certificates.array_types import BoolArray, FloatArray, IntArray
from barrier_certificates.batch.certify import FAILED, OPTIMAL, RELAXED, TRIVIAL
from barrier_certificates.projection import ProjectionInfo, Status

__all__ = ["STATUSES", "BatchInfo"]

STATUSES = {
    TRIVIAL: Status.TRIVIAL,
    OPTIMAL: Status.OPTIMAL,
    RELAXED: Status.RELAXED,
    FAILED: Status.FAILED,
}
"""What the numbers in `BatchInfo.status` stand for."""
_CODES = {status: code for code, status in STATUSES.items()}


@dataclass(frozen=True, eq=False)
class BatchInfo:
    """What a call did for each of B teams; see `ProjectionInfo` for one.

    Attributes
    ----------
    status : (B,) integer array
        Keys of `STATUSES`.
    violation : (B,) array
        Largest excess over all rows, m/s.
    intervention : (B,) array
        How far velocities are from what was desired, the largest over the robots, m/s.
    clearance : (B,) array
        How far each team is from being unsafe, m.
    smallest_h : (B,) array
        The barrier of what has that clearance, m² or m.
    unsafe_start : (B,) boolean array
        Whether this was a team's first call and found it unsafe already.
    handed_over : int
        How many teams a single certificate answered for.
    """

    status: IntArray
    violation: FloatArray
    intervention: FloatArray
    clearance: FloatArray
    smallest_h: FloatArray
    unsafe_start: BoolArray
    handed_over: int

    def statuses(self) -> list[Status]:
        """Return the status of each team as a word."""
        return [STATUSES[code] for code in self.status.tolist()]

    @property
    def counts(self) -> dict[Status, int]:
        """How many teams have which status."""
        return {word: int(np.sum(self.status == code)) for code, word in STATUSES.items()}


def numbers_of(info: ProjectionInfo) -> tuple[int, FloatArray]:
    """Return the status of one projection as a number, and what it measured.

    Parameters
    ----------
    info : ProjectionInfo
        What was done for one team.

    Returns
    -------
    status : int
        A key of `STATUSES`.
    numbers : (4,) array
        Violation, intervention, clearance, smallest h.
    """
    measured = (info.violation, info.intervention, info.clearance, info.smallest_h)
    return _CODES[info.status], np.array(measured)
