"""The Robotarium of generation 2: ``get_poses``, ``set_velocities``, ``step``, in that order.

r = Robotarium(number_of_robots=5, show_figure=True, initial_conditions=poses)
for k in range(1000):
    x = r.get_poses()                       # (3, N), a copy
    r.set_velocities(np.arange(5), dxu)     # (2, N)
    r.step()
r.debug()
"""

import time

import numpy as np
from numpy.typing import NDArray

from rps_compat.arena import Array
from rps_compat.errors import CallOrderError
from rps_compat.v2.robotarium_abc import ARobotarium

__all__ = ["ARobotarium", "NDArray", "Robotarium", "np", "time"]


class Robotarium(ARobotarium):
    """N robots in the arena, commanded as unicycles. See :class:`ARobotarium`."""

    def get_poses(self) -> Array:
        """Copy of the poses (3, N) as tracked: metres, and headings within (−π, π].

        Raises
        ------
        CallOrderError
            Called twice without ``step`` between: on the testbed that would read old poses.
        """
        if self._checked_poses_already:
            raise CallOrderError(
                "get_poses() was called twice in one time step: keep its result, call step(), "
                "then call get_poses() again"
            )
        self._called_step_already = False
        self._checked_poses_already = True
        return np.array(self._arena.observe())

    def initialize(self, initial_conditions: Array) -> None:
        """Bring the robots to `initial_conditions` (3, N)."""

    def step(self) -> None:
        """Drive all robots for one time step of 33 ms.

        Raises
        ------
        CallOrderError
            Called without ``get_poses`` since the last step.
        CommandError
            The commands are not finite.
        """
        if self._called_step_already:
            raise CallOrderError(
                "step() was called without get_poses() before it: each time step calls "
                "get_poses(), then set_velocities(), then step()"
            )
        self._called_step_already = True
        self._checked_poses_already = False
        arena = self._obey_constants()
        arena.step()

    def debug(self) -> None:
        """Print what the testbed would say about this run: duration, violations."""
