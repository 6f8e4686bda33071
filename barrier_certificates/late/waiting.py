"""Where robots that are too close have no safe way to move, these wait, and the others go on.

Cautious rows ask who is seen too close to draw apart, and a robot between two others or in a corner
may not be able to. To stop is always safe: stop points stay where they are. So those robots stop,
and the program is solved for the others, for whom these are things that stand still.
"""

from __future__ import annotations

import math

import numpy as np

from barrier_certificates.array_types import FloatArray
from barrier_certificates.late.cautious_rows import CautiousRows
from barrier_certificates.projection import ProjectionInfo, Projector, Status
from barrier_certificates.projection.projector import largest_speed
from barrier_certificates.rows import Rows

__all__ = ["WaitingProjector"]


class WaitingProjector(Projector):
    """A projector that stops who is too close, before it stops everybody.

    Parameters
    ----------
    projector : Projector
        Whose solver, policy and options it has.
    cautious : CautiousRows
        Who has added rows for what is too close.
    """

    def __init__(self, projector: Projector, cautious: CautiousRows) -> None:
        self.on_infeasible = projector.on_infeasible
        self._search = projector._search
        self._cautious = cautious

    def project(
        self, desired: FloatArray, rows: Rows, top_speed: float = math.inf
    ) -> tuple[FloatArray, ProjectionInfo]:
        """Return the nearest velocities that satisfy all rows, else those of who may go on."""
        velocity, info = super().project(desired, rows, top_speed)
        added = self._cautious.number
        if info.status is not Status.FAILED or not added or not math.isfinite(info.intervention):
            return velocity, info
        before = len(rows) - added
        touched = rows.index[:, before:]
        waits = np.zeros(rows.size // 2 + 1, dtype=bool)
        waits[touched // 2] = True
        waits[-1] = False  # the world
        index = rows.index[:, :before]
        fewer = Rows(
            index,
            np.where(waits[index // 2], 0.0, rows.coefficient[:, :before]),
            rows.bound[:before],
            rows.size,
            rows.weight[:before],
            rows.label,
        )
        wish = np.where(waits[:-1], 0.0, desired)
        velocity, info = super().project(wish, fewer, top_speed)
        if info.status is Status.TRIVIAL:
            info.status = Status.OPTIMAL
        info.intervention = largest_speed(velocity - desired)
        return velocity, info
