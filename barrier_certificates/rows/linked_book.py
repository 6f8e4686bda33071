"""The rows of a team that stays connected: those of a row book, and those of the links it keeps."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from barrier_certificates.rows.kept_links import ConnectivityParameters, KeptLinks
from barrier_certificates.rows.links import LinkBarrier, LinkRows
from barrier_certificates.rows.pairs import PairRows
from barrier_certificates.rows.row_book import Margin, RowBook
from barrier_certificates.rows.row_family import Barrier, RowFamily, Scene
from barrier_certificates.rows.row_set import Rows


class LinkedRowBook(RowBook):
    """A row book with the rows of links, laid out anew whenever others are kept.

    Parameters
    ----------
    families, pairs, top_speed
        See `barrier_certificates.rows.row_book.RowBook`.
    connectivity : ConnectivityParameters
        Which links are kept.
    barrier : LinkBarrier
        What is kept of them.
    """

    def __init__(
        self,
        families: Sequence[RowFamily],
        pairs: PairRows | None,
        top_speed: float,
        connectivity: ConnectivityParameters,
        barrier: LinkBarrier,
    ) -> None:
        super().__init__(families, pairs, top_speed)
        self._others = self.families
        self._barrier = barrier
        self._kept = KeptLinks(connectivity)
        self._rows_of_links = LinkRows(np.zeros((2, 0), dtype=np.intp), barrier)

    def write(self, scene: Scene) -> tuple[Rows, Barrier]:
        """Return the rows for a scene, and the barrier of least clearance in it.

        Parameters
        ----------
        scene : Scene
            Where the team is.

        Returns
        -------
        rows : Rows
            All rows, m/s.
        nearest : Barrier
            The one of least clearance; links have none.
        """
        links = self._kept.keep(scene.positions)
        if links is not self._rows_of_links.links:
            self._rows_of_links = LinkRows(links, self._barrier)
            self.families = self._with(self._rows_of_links)
            self.forget()
        return super().write(scene)

    def longest_link(self) -> tuple[float, int]:
        """Return what is left of the range at the longest link written last, m, and its row."""
        for family, start, *_ in self._sections:
            if family is self._rows_of_links:
                left, row = self._rows_of_links.longest
                return left, start + row
        return math.inf, -1

    def margins(self, scene: Scene, within: float) -> list[Margin]:
        """Return what is near to being unsafe or to being lost, the closest first.

        Parameters
        ----------
        scene : Scene
            Where the team is.
        within : float
            Leave out what is clear by more than this, m.
        """
        links = LinkRows(self._kept.choose(scene.positions), self._barrier)
        return RowBook(self._with(links), self.pairs, self.top_speed).margins(scene, within)

    def reset(self) -> None:
        """Forget which links were kept."""
        self._kept.forget()

    def _with(self, links: LinkRows) -> tuple[RowFamily, ...]:
        return (*self._others, links)
