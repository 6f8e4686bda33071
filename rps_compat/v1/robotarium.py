"""The Robotarium of generation 1: ``get_poses``, ``set_velocities``, ``step``, in that order.

::

    r = Robotarium(number_of_robots=5, show_figure=True, sim_in_real_time=True)
    for k in range(1000):
        x = r.get_poses()                       # (3, N)
        r.set_velocities(np.arange(5), dxu)     # (2, N)
        r.step()
    r.call_at_scripts_end()
"""

import math
import time
from abc import ABC, abstractmethod

import numpy as np

from rps_compat.arena import Array
from rps_compat.errors import CallOrderError
from rps_compat.lazy import LazyModule
from rps_compat.report import report_on
from rps_compat.v1.robotarium_abc import RobotariumABC

plt = LazyModule("matplotlib.pyplot")
patches = LazyModule("matplotlib.patches")
misc = LazyModule("rps_compat.v1.utilities.misc")

# Scripts get these names from `import *`, so every one of them is part of the interface.
__all__ = [
    "ABC", "Robotarium", "RobotariumABC", "abstractmethod", "math", "misc", "np", "patches", "plt",
    "time",
]  # fmt: skip


class Robotarium(RobotariumABC):
    """N robots in the arena, commanded as unicycles. See :class:`RobotariumABC`."""

    def get_poses(self) -> Array:
        """Poses (3, N) as tracked: x and y in metres, heading in radians within (−π, π].

        The array is live: it changes with every ``step``. One call per step.

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
        return self._reported

    def step(self) -> None:
        """Drive all robots for one time step of 33 ms.

        Raises
        ------
        CallOrderError
            Called without ``get_poses`` since the last step.
        CommandError
            The commands kept by ``set_velocities`` are not finite or not of shape (2, N).
        """
        if self._called_step_already:
            raise CallOrderError(
                "step() was called without get_poses() before it: each time step calls "
                "get_poses(), then set_velocities(), then step()"
            )
        self._called_step_already = True
        self._checked_poses_already = False
        self._obey_constants().step()
        self._after_step()

    def call_at_scripts_end(self) -> None:
        """Print what the testbed would say about this run: duration, violations."""
        print(report_on(self._arena).text(1), end="")
