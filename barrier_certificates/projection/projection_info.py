"""What a projection did, for logs and for people."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from barrier_certificates.array_types import IntArray
from barrier_certificates.rows.row_set import Rows
from barrier_certificates.word_enum import WordEnum

NO_ROWS: IntArray = np.zeros(0, dtype=np.intp)


class Status(WordEnum):
    """What became of a command; a member equals its word, as ``info.status == "optimal"``."""

    #: It was safe, and is returned as it was.
    TRIVIAL = "trivial"
    #: The nearest safe velocity is returned.
    OPTIMAL = "optimal"
    #: No safe velocity exists; the one returned breaks the rows least.
    RELAXED = "relaxed"
    #: The robots were stopped: policy ``"stop"``, or NaN in poses or command, which leaves the
    #: other numbers NaN.
    FAILED = "failed"


@dataclass(slots=True, eq=False)
class ProjectionInfo:
    """What a projection did.

    Attributes
    ----------
    status : Status
        ``"trivial"``, ``"optimal"``, ``"relaxed"`` or ``"failed"``.
    violation : float
        Largest excess over all rows at the velocity returned, m/s; zero if all hold.
    iterations : int
        Small problems solved.
    solver : str
        Who gave the answer; empty for a trivial one.
    intervention : float
        How far the velocity returned is from the command, the largest over the robots, m/s.
    clearance : float
        How far the team is from being unsafe, m: the least over pairs and obstacles of distance
        less radius, over walls of distance less margin. Negative exactly when something is unsafe.
    smallest_h : float
        The barrier h of what has that clearance (see `nearest`): ‖D‖² − r² in m² for a pair or an
        obstacle, the distance less the margin in m for a wall.
    unsafe_start : bool
        Whether this was a certificate's first call, or the first since `reset`, and found the team
        unsafe already (clearance below zero). The guarantee h ≥ 0 starts from h ≥ 0: until the
        team has become safe, it says nothing.
    range_left : float
        What is left of the communication range at the longest link that is kept, m; negative where
        the team is not connected, or a link is lost. Infinite without links.
    disconnected_start : bool
        Whether this was such a first call, and found `range_left` negative.
    binding : (k,) integer array
        Indices of the rows that bind.
    broken : (k,) integer array
        Indices of the rows that do not hold, the furthest from holding first; empty unless the
        status is ``"relaxed"`` or ``"failed"``.
    stuck : (k,) integer array
        Robots that have been told to move but held back for some time, where a certificate watches
        for it (its ``deadlock`` parameters).
    rows : Rows, optional
        All rows; their numbers are written again by the next call.
    nearest_row : int
        The row of what is nearest to being unsafe; −1 where there is nothing.
    link_row : int
        A row of the longest link that is kept; −1 where there is none.
    """

    status: Status
    violation: float = 0.0
    iterations: int = 0
    solver: str = ""
    intervention: float = 0.0
    clearance: float = math.inf
    smallest_h: float = math.inf
    unsafe_start: bool = False
    range_left: float = math.inf
    disconnected_start: bool = False
    binding: IntArray = field(default_factory=lambda: NO_ROWS, repr=False)
    broken: IntArray = field(default_factory=lambda: NO_ROWS, repr=False)
    stuck: IntArray = field(default_factory=lambda: NO_ROWS)
    rows: Rows | None = field(default=None, repr=False)
    nearest_row: int = field(default=-1, repr=False)
    link_row: int = field(default=-1, repr=False)

    @property
    def deadlocked(self) -> bool:
        """Whether any robot is stuck."""
        return bool(self.stuck.shape[0])

    @property
    def active(self) -> tuple[str, ...]:
        """What the binding rows stand for: ``"robots 3 and 7"``, ``"robot 0 and wall +x"``.

        A link is ``"robots 3 and 7 in range"``; it has two rows in steps of time, and is named
        twice where both bind.
        """
        return self._named(self.binding)

    @property
    def violated(self) -> tuple[str, ...]:
        """What the rows that do not hold stand for, the furthest from holding first."""
        return self._named(self.broken)

    @property
    def nearest(self) -> str | None:
        """What is nearest to being unsafe, as `active` names it; None where there is nothing."""
        return self._name(self.nearest_row)

    @property
    def longest_link(self) -> str | None:
        """Which link is nearest to being lost, as `active` names it; None where there is none."""
        return self._name(self.link_row)

    def _name(self, row: int) -> str | None:
        if self.rows is None or row < 0:
            return None
        return self.rows.label(row)

    def _named(self, rows: IntArray) -> tuple[str, ...]:
        if self.rows is None:
            return ()
        return tuple(self.rows.label(int(row)) for row in rows)
