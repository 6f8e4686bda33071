"""What wheels may do on their own, and how much of a row that can cost.

A differential-drive robot whose wheels turn at ``u + w``, with ``|w| ≤ δ`` for each wheel, moves
its projection point with ``q̇ = G (u + w)``. A row ``a·q̇ ≤ b`` holds for every such ``w`` when it
holds with ``b − δ‖aᵀG‖₁``: the worst of the four corners. This is the robust barrier function of
Emam, Glotfelter and Egerstedt (Robust Barrier Functions for a Fully Autonomous, Remotely Accessible
Swarm-Robotics Testbed, 2019) for a disturbance that enters with the input.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.rows import FloatArray, IntArray, Scene


@dataclass(frozen=True)
class WheelDisturbance:
    """A bounded disturbance on the wheels of every robot.

    Parameters
    ----------
    bound : float
        δ, the largest unwanted speed of a wheel, rad/s.
    wheel_radius, base_length : float
        Radius of the wheels and distance between them, m.
    projection_distance : float
        How far ahead of the axle the projection point lies, m.
    """

    bound: float
    wheel_radius: float
    base_length: float
    projection_distance: float

    def worst(self, scene: Scene, robots: IntArray, normals: FloatArray) -> FloatArray:
        """How much a row may lose through these robots, shape (m,), m/s.

        Parameters
        ----------
        scene : Scene
            Where the team is, headings included.
        robots : (m,) integer array
            The robot in each row.
        normals : (2, m) array
            Its coefficients in the row.
        """
        if scene.headings is None:
            raise ParameterError("a wheel disturbance needs robots that have headings")
        cos, sin = scene.headings.take(robots, axis=1)
        x, y = normals
        along = np.abs(x * cos + y * sin) * self._along
        across = np.abs(y * cos - x * sin) * self._across
        # ‖aᵀG‖₁ = |p − q| + |p + q| = 2 max(|p|, |q|) of the forward and turning parts.
        return np.asarray(np.maximum(along, across))

    def top_speed(self) -> float:
        """Speed that the disturbance alone can give the projection point, m/s."""
        return math.hypot(self._along, self._across)

    @property
    def _along(self) -> float:
        return abs(self.bound * self.wheel_radius)

    @property
    def _across(self) -> float:
        return abs(self._along * 2.0 * self.projection_distance / self.base_length)
