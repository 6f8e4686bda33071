"""What wheels may do on their own, and how much of a row that can cost.

A differential-drive robot whose wheels turn at ``u + w``, with ``|w| ≤ δ`` for each wheel, moves
its projection point with ``q̇ = G (u + w)``. A row ``a·q̇ ≤ b`` holds for every such ``w`` when it
holds with ``b − δ‖aᵀG‖₁``: the worst of the four corners. This is the robust barrier function of
Emam, Glotfelter and Egerstedt (Robust Barrier Functions for a Fully Autonomous, Remotely Accessible
Swarm-Robotics Testbed, 2019) for a disturbance that enters with the input.

The four corners are those of a rhombus in the body frame: both wheels turning the same way move the
point along the heading, turning opposite ways across it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.per_robot import PerRobot
from barrier_certificates.rows.row_family import Scene


@dataclass(frozen=True)
class WheelDisturbance:
    """Unwanted velocities of a point that turns with its robot: the rhombus with these half-axes.

    Parameters
    ----------
    along, across : float or (N,) array-like
        The largest unwanted velocities along the heading and across it, m/s: of all robots, or of
        each.
    """

    along: PerRobot
    across: PerRobot

    def worst(self, scene: Scene, robots: IntArray, normals: FloatArray) -> FloatArray:
        """Return how much each row may lose through its robot's wheels.

        Parameters
        ----------
        scene : Scene
            Where the team is, headings included.
        robots : (m,) integer array
            The robot in each row.
        normals : (2, m) array
            Its coefficients in the row.

        Returns
        -------
        (m,) array
            Loss, m/s.

        Raises
        ------
        ParameterError
            If the robots of the scene have no headings.
        """
        if scene.headings is None:
            raise ParameterError("a wheel disturbance needs robots that have headings")
        cos, sin = scene.headings.take(robots, axis=1)
        x, y = normals
        along = np.abs(x * cos + y * sin) * _of_rows(self.along, robots)
        across = np.abs(y * cos - x * sin) * _of_rows(self.across, robots)
        # The worst corner of a rhombus is one of its four.
        return np.asarray(np.maximum(along, across))

    def top_speed(self) -> float:
        """Speed that the disturbance alone can give the point, m/s; never less than it is."""
        if isinstance(self.along, tuple) and isinstance(self.across, tuple):
            return max(map(math.hypot, self.along, self.across))
        return math.hypot(self.along, self.across)  # type: ignore[arg-type]


def _of_rows(size: PerRobot, robots: IntArray) -> float | FloatArray:
    """Return what counts for the robot in each row."""
    return np.take(size, robots) if isinstance(size, tuple) else size  # type: ignore[return-value]
