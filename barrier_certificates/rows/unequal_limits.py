"""Rows of what robots can do that are not alike: a polygon for each, of the same sides.

The rows lie as those of equal robots do, side by side and robot by robot, so a side that one robot
needs is there for all; to others it is a row that their other sides imply.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.certificate_errors import ParameterError, ShapeError
from barrier_certificates.rows.limits import LimitRows, VelocityPolygon


class UnequalLimitRows(LimitRows):
    """Every robot's velocity stays inside its own polygon.

    Parameters
    ----------
    polygons : sequence of VelocityPolygon
        One for each robot, N, of the same sides in the same order; their bounds and normals differ.
    turning : bool
        Whether polygons turn with the robots' headings.

    Raises
    ------
    ParameterError
        If polygons have other sides than the first.
    """

    def __init__(self, polygons: Sequence[VelocityPolygon], turning: bool = False) -> None:
        first = polygons[0]
        for robot, polygon in enumerate(polygons):
            if polygon.names != first.names:
                raise ParameterError(
                    f"the polygon of robot {robot} has the sides {polygon.names}; expected those of"
                    f" robot 0, {first.names}"
                )
        kept = sorted({side for polygon in polygons for side in polygon.needed_sides()})
        few = [polygon.with_sides(kept) for polygon in polygons]
        fastest = max(polygon.top_speed() for polygon in few)
        super().__init__(few[0].normals, few[0].bounds, few[0].names, turning, fastest)
        # Robots differ fastest, as in the rows: (2, K, N) and (K, N).
        self.normals = np.stack([polygon.normals for polygon in few], axis=-1)
        self.bounds = np.stack([polygon.bounds for polygon in few], axis=-1)

    def partners(self, number: int) -> IntArray:
        """Return which robots each row joins.

        Raises
        ------
        ShapeError
            If there are not as many polygons.
        """
        if number != self.bounds.shape[1]:
            raise ShapeError(
                f"limits are for {self.bounds.shape[1]} robots, but the team has {number}"
            )
        return super().partners(number)

    def prepare(self, number: int, coefficient: FloatArray, bound: FloatArray) -> None:
        """Write what does not turn."""
        coefficient[:2] = self.normals.reshape(2, -1)
        bound[:] = self.bounds.reshape(-1)

    def _turn(self, headings: FloatArray, coefficient: FloatArray) -> None:
        """Write each normal, turned by the heading of its robot."""
        along, across = self.normals
        cos, sin = headings
        coefficient[0] = (along * cos - across * sin).reshape(-1)
        coefficient[1] = (across * cos + along * sin).reshape(-1)
