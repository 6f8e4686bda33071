"""The Robotarium of generation 2: ``get_poses``, ``set_velocities``, ``step``, in that order.

::

    r = Robotarium(number_of_robots=5, show_figure=True, initial_conditions=poses)
    for k in range(1000):
        x = r.get_poses()                       # (3, N), a copy
        r.set_velocities(np.arange(5), dxu)     # (2, N)
        r.step()
    r.debug()
"""

import time
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rps_compat.arena import Array
from rps_compat.errors import CallOrderError
from rps_compat.initial import checked_poses
from rps_compat.initial_drive import drive_to
from rps_compat.report import report_on
from rps_compat.v2.robotarium_abc import ARobotarium

# Scripts get these names from `import *`, so every one of them is part of the interface.
_FROM_UTILITIES = {
    "create_at_pose": "misc",
    "create_pose_controller_hybrid": "controllers",
    "create_uni_barrier_certificate": "barrier_certificates",
    "determine_font_size": "misc",
    "generate_initial_poses": "misc",
    "generate_random_poses": "misc",
    "simulate_distance_sensors": "sensors",
}
__all__ = ["ARobotarium", "NDArray", "Robotarium", "np", "time", *_FROM_UTILITIES]


def __getattr__(name: str) -> Any:
    if name in _FROM_UTILITIES:
        module = import_module(f"rps_compat.v2.utilities.{_FROM_UTILITIES[name]}")
        return getattr(module, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


class Robotarium(ARobotarium):
    """N robots in the arena, commanded as unicycles. See :class:`ARobotarium`.

    Parameters
    ----------
    **kwargs
        As for :class:`ARobotarium`.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        own = (getattr(type(self), name) is getattr(Robotarium, name) for name in _SIMULATIONS)
        self._senses_itself = all(own)
        if self._mode == "drive":
            self.initialize(self._targets)

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
        """Drive the robots from where they are to where the experiment begins.

        The steps count: on the testbed the drive is part of the run.

        Parameters
        ----------
        initial_conditions : (3, N) array
            Their poses there, m and rad.

        Raises
        ------
        InitialConditionsError
            Robots cannot stand there: outside, or too close to each other.
        UnreachableError
            They did not arrive; the message says which, and how far they were.
        """
        targets = checked_poses(initial_conditions, self.number_of_robots)
        print(f"Initializing {self.number_of_robots} robots to initial conditions...")
        self.initializing = True
        drive_to(self._obey_constants(), targets, self._random(), self._after_step)
        self.initializing = False
        print("At initial conditions... Starting Experiment")

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
        self._velocities_old = arena.velocities
        arena.step()
        self._after_step()

    def _after_step(self) -> None:
        if self._senses_itself:
            self._suite.sense()
        else:
            self._sense_by_methods()
        if self._pace is not None:
            self._pace.after_step(self.TIME_STEP)

    def _sense_by_methods(self) -> None:
        # A subclass has its own sensors: let it simulate each in the published order.
        if self._distance_sensors_enabled:
            self._suite.sense_distances()
        self._suite.remember()
        for method in _SIMULATIONS:
            getattr(self, method)()

    def _draw_noise(self, rows: int) -> Array:
        self._suite.remember()
        noise: Array = np.random.randn(rows, self.number_of_robots)  # noqa: NPY002 - published stream
        return noise

    def simulate_encoder_readings(self) -> None:
        """Count the encoders' ticks of the last step."""
        self._suite.count_ticks(self._draw_noise(2))

    def simulate_accelerations(self) -> None:
        """Read the accelerometers after the last step."""
        self._suite.feel_accelerations(self._draw_noise(3))

    def simulate_gyros(self) -> None:
        """Read the gyroscopes after the last step."""
        self._suite.feel_turning(self._draw_noise(3))

    def simulate_magnetometers(self) -> None:
        """Read the magnetometers after the last step."""
        self._suite.feel_magnetic_fields(self._draw_noise(3))

    def simulate_orientations(self) -> None:
        """Read the headings after the last step."""
        self._suite.feel_orientations(self._draw_noise(1)[0])

    def debug(self) -> None:
        """Print what the testbed would say about this run: duration, errors, warnings."""
        print(report_on(self._arena).text(2), end="")


_SIMULATIONS = (
    "simulate_encoder_readings",
    "simulate_accelerations",
    "simulate_gyros",
    "simulate_magnetometers",
    "simulate_orientations",
)
