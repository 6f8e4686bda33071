"""What a certificate keeps from step to step: rows in arrays, who bound, who was held."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from barrier_certificates import ties
from barrier_certificates.deadlock import DeadlockMonitor
from barrier_certificates.projection import ProjectionInfo, Projector
from barrier_certificates.rows import Barrier, Obstacle, ObstacleRows, RowBook, WallRows
from barrier_certificates.rows.linked_book import LinkedRowBook
from barrier_certificates.rows.obstacles import listed


@dataclass(eq=False, repr=False)
class StepMemory:
    """What a certificate keeps from step to step; it makes steps faster, and watches.

    Parameters
    ----------
    book : RowBook
        Writes the rows; one of links decides which are kept.
    walls : WallRows, optional
        What keeps robots inside.
    obstacles : ObstacleRows
        What keeps them off obstacles.
    projector : Projector
        Who finds the nearest velocities.
    monitor : DeadlockMonitor, optional
        Who watches for robots that are held.
    fresh : bool
        Whether the next call is the first.
    """

    book: RowBook
    walls: WallRows | None
    obstacles: ObstacleRows
    projector: Projector
    monitor: DeadlockMonitor | None
    fresh: bool = True

    def reset(self) -> None:
        """Forget who bound, who was held and which links were kept: the next call is the first."""
        self.fresh = True
        self.projector.reset()
        if self.monitor is not None:
            self.monitor.reset()
        if isinstance(self.book, LinkedRowBook):
            self.book.reset()

    def place(self, obstacles: Sequence[Obstacle]) -> None:
        """Put obstacles where they are now.

        Parameters
        ----------
        obstacles : sequence of Disc or Segment
            All there are.
        """
        if obstacles is self.obstacles.obstacles:
            return
        found, number = listed(obstacles), len(self.obstacles.obstacles)
        if not found and not number:  # a list that stays empty costs nothing
            return
        self.obstacles.move(found)
        if len(found) != number:
            self.book.forget()
            self.projector.reset()

    def tell(self, info: ProjectionInfo, nearest: Barrier) -> None:
        """Say in a report how near the team was to being unsafe, and to falling apart.

        Parameters
        ----------
        info : ProjectionInfo
            What was done; told here.
        nearest : Barrier
            What is nearest to being unsafe.
        """
        info.smallest_h, info.clearance, info.nearest_row = nearest
        info.unsafe_start = self.fresh and info.clearance < 0.0
        if isinstance(self.book, LinkedRowBook):
            info.range_left, info.link_row = self.book.longest_link()
            info.disconnected_start = self.fresh and bool(ties.short_of(info.range_left, 0.0))
        self.fresh = False
