"""What every Robotarium of generation 1 has: constructor, commands, wheels, validation."""

import math
import time
import weakref
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from rps_compat import session
from rps_compat.arena import Arena, Array, require_finite
from rps_compat.errors import CommandError, ConstructorError
from rps_compat.figure import ArenaFigure
from rps_compat.initial import checked_poses, drawn_poses, first_poses
from rps_compat.initial_drive import drive_to
from rps_compat.lazy import LazyModule
from rps_compat.pace import pace_of
from rps_compat.report import MESSAGES
from rps_compat.testbed import GRITSBOT_X, RobotModel
from rps_compat.v1.drawing import GritsbotPatches
from rps_compat.v1.sensing import SensorFace
from rps_compat.violations import FaultKind
from rps_compat.wrong_generation import refuse, refuse_new_arguments

plt = LazyModule("matplotlib.pyplot")
patches = LazyModule("matplotlib.patches")
misc = LazyModule("rps_compat.v1.utilities.misc")

# Scripts get these names from `import *`, so every one of them is part of the interface.
__all__ = [
    "ABC", "RobotariumABC", "abstractmethod", "math", "misc", "np", "patches", "plt", "time",
]  # fmt: skip


class RobotariumABC(SensorFace, ABC):
    """The parts of a Robotarium that do not depend on where its robots are.

    Parameters
    ----------
    number_of_robots : int
        1 to 50.
    show_figure : bool
        Whether the arena is drawn. Without it no figure is made until ``axes`` or ``figure`` is
        asked for.
    sim_in_real_time : bool
        Whether ``step`` waits for its slot of 33 ms (in a window; nobody waits without one).
    initial_conditions : (3, N) array
        Poses, m and rad; an empty array draws them at random.
    use_distance_sensors : bool
        Whether the seven infrared sensors are simulated.
    obstacles : (M, 2, 2) array
        Segments that they see: the ends' x in a row and their y in another, m.

    Raises
    ------
    ConstructorError, InitialConditionsError
        What is wrong with the arguments, and what was expected. Both are AssertionErrors.
    """

    @refuse_new_arguments
    def __init__(
        self,
        number_of_robots: int = -1,
        show_figure: bool = True,
        sim_in_real_time: bool = True,
        initial_conditions: Array = np.array([]),  # noqa: B008 - the published default
        use_distance_sensors: bool = False,
        obstacles: Array = np.full((1, 2, 2), np.nan),  # noqa: B008 - the published default
    ) -> None:
        _check(number_of_robots, show_figure, sim_in_real_time)
        self.number_of_robots = number_of_robots
        self.show_figure = show_figure
        self.initial_conditions = initial_conditions
        self.sim_in_real_time = sim_in_real_time

        self._set_constants()
        self._called_step_already = True
        self._checked_poses_already = False
        self._session = session.current()
        rng = cache(self._session.generator)  # one stream, drawn from only if it is needed
        targets = self._targets(initial_conditions, rng)
        self.initial_conditions = targets.copy()
        self._model_key: tuple[float, ...] = self._constants()
        mode = self._session.mode(published="exact")
        poses = first_poses(targets, mode, self._model(), rng)
        self._arena = self._session.arena(poses, self._model(), rng)
        self._reported = self._arena.observe()
        self._begin_sensing(use_distance_sensors, obstacles)
        self.previous_render_time = time.time()
        self.file_path = None
        self.current_file_size = 0
        self.left_led_commands: list[Any] = []
        self.right_led_commands: list[Any] = []
        self.base_patches: list[Any] = []
        self._patches: GritsbotPatches | None = None
        self._picture: ArenaFigure | None = None
        if show_figure:
            self._open_figure().show()
        self._pace = pace_of(self._picture, sim_in_real_time, self._session)
        if self._session.created is not None:
            self._session.created(self)
        if mode == "drive":
            drive_to(self._arena, targets, rng(), self._after_step)

    def _set_constants(self) -> None:
        # Constants of the testbed. Scripts read them, and some change them: every step obeys.
        self.time_step = GRITSBOT_X.time_step
        self.robot_diameter = 0.11
        self.robot_length = 0.095
        self.robot_width = 0.09
        self.robot_radius = self.robot_diameter / 2
        self.wheel_radius = GRITSBOT_X.wheel_radius
        self.base_length = GRITSBOT_X.base_length
        self.max_linear_velocity = 0.2
        self.max_angular_velocity = 2 * (self.wheel_radius / self.robot_diameter) * (0.2 / 0.016)
        self.max_wheel_velocity = self.max_linear_velocity / self.wheel_radius
        self.collision_offset = GRITSBOT_X.collision_offset
        self.collision_diameter = GRITSBOT_X.collision_diameter
        self.boundaries: list[float] = [-1.6, -1, 3.2, 2]

    def _after_step(self) -> None:
        arena = self._arena
        if arena.realism is not None or self._reported is not arena.poses:
            self._report(arena)
        self._after_sensed_step()
        if self._pace is not None:
            self._pace.after_step(self.time_step)

    def _report(self, arena: Arena) -> None:
        """Let the live array hold what is tracked now: the true poses, where that is ideal."""
        if arena.realism is None:
            self._reported = arena.poses
        elif self._reported is arena.poses:  # imperfect since this step
            self._reported = np.array(arena.observe())
        else:
            self._reported[:] = arena.observe()

    def _open_figure(self) -> ArenaFigure:
        arena = self._arena
        x, y, width, height = self.boundaries
        limits = (x - 0.1, x + width + 0.1, y - 0.1, y + height + 0.1)
        me = weakref.ref(self)

        def update() -> None:
            of = me()
            if of is not None and of._patches is not None:
                of._patches.follow()

        picture = self._picture = ArenaFigure(self, (6.4, 4.8), limits, update)
        self.figure: Any = picture.figure
        self.axes: Any = picture.axes
        self._patches = GritsbotPatches(
            picture.axes, lambda: arena.poses, self.robot_length, self.robot_width, self.boundaries
        )
        for ends in np.asarray(self.obstacles, dtype=float).reshape(-1, 2, 2):
            if not np.isnan(ends).any():  # the published default stands for none
                self.axes.plot(*ends, color="0.5", linewidth=4)
        return picture

    def _targets(self, initial_conditions: Array, rng: Callable[[], np.random.Generator]) -> Array:
        robots = self.number_of_robots
        if np.shape(initial_conditions) == (0,):

            def draw(spacing: float) -> Array:
                poses: Array = misc.generate_initial_conditions(
                    robots, spacing=spacing, width=2.5, height=1.5
                )
                return poses

            return drawn_poses(draw, 0.2, robots, self._model(), rng)
        return checked_poses(initial_conditions, self.number_of_robots)

    def __getattr__(self, name: str) -> Any:
        if name in ("figure", "axes"):  # made when first asked for
            self._open_figure()
            return self.__dict__[name]
        if name == "boundary_patch" and self.show_figure and self._patches is not None:
            return self._patches.boundary
        return refuse(self, name, generation=1)

    def _shown(self, kind: str) -> list[Any]:
        return getattr(self._patches, kind) if self.show_figure and self._patches else []

    @property
    def chassis_patches(self) -> list[Any]:
        """Rectangles of the robots' bodies; empty without a figure."""
        return self._shown("chassis")

    @property
    def left_led_patches(self) -> list[Any]:
        """Circles of the left LEDs; empty without a figure."""
        return self._shown("left_leds")

    @property
    def right_led_patches(self) -> list[Any]:
        """Circles of the right LEDs; empty without a figure."""
        return self._shown("right_leds")

    @property
    def left_wheel_patches(self) -> list[Any]:
        """Circles of the left wheels; empty without a figure."""
        return self._shown("left_wheels")

    @property
    def right_wheel_patches(self) -> list[Any]:
        """Circles of the right wheels; empty without a figure."""
        return self._shown("right_wheels")

    def _constants(self) -> tuple[float, ...]:
        return (
            self.wheel_radius,
            self.base_length,
            self.max_wheel_velocity,
            self.collision_diameter,
            self.collision_offset,
            self.time_step,
            *self.boundaries,
        )

    def _model(self) -> RobotModel:
        *robot, x, y, width, height = self._constants()
        wheel, base, limit, diameter, offset, step = robot
        edges = (x, x + width, y, y + height)
        return RobotModel(wheel, base, limit, diameter, offset, step, edges)

    def _obey_constants(self) -> Arena:
        constants = self._constants()
        if constants != self._model_key:
            self._model_key, self._arena.robot = constants, self._model()
        return self._arena

    @property
    def poses(self) -> Array:
        """Poses (3, N) as tracked: a live array, which ``step`` changes in place."""
        return self._reported

    @poses.setter
    def poses(self, poses: Array) -> None:
        self._arena.place(checked_poses(np.asarray(poses), self.number_of_robots))
        self._reported = self._arena.observe()

    @property
    def velocities(self) -> Array:
        """Velocities (2, N) commanded, m/s and rad/s; after ``step`` cut at the wheels' limits."""
        return self._arena.commands

    @velocities.setter
    def velocities(self, velocities: Array) -> None:
        self._arena.commands = velocities

    @property
    def _iterations(self) -> int:
        return self._arena.steps

    @property
    def _errors(self) -> dict[str, Any]:
        found = self._arena.violations
        errors: dict[str, Any] = {}
        for kind, count in (
            (FaultKind.BOUNDARY, dict(found.outside_by_robot)),
            (FaultKind.COLLISION, dict(found.close_by_robot)),
            (FaultKind.ACTUATOR, found.saturated_steps),
        ):
            if count:
                errors[kind.value] = count  # scripts look for the words
                errors[f"{kind}_string"] = MESSAGES[kind]
        return errors

    @_errors.setter
    def _errors(self, errors: dict[str, Any]) -> None:
        # Scripts that copy the published step write `self._errors = self._validate()`, and those
        # that start counting afresh write {}.
        if not errors:
            self._arena.forget_violations()

    def set_velocities(self, ids: Any, velocities: Array) -> None:
        """Command all robots, from the next step on.

        Parameters
        ----------
        ids : object
            Ignored, as by the published simulator: the columns of `velocities` are the robots.
        velocities : (2, N) array
            Forward speeds, m/s, and turn rates, rad/s; the array itself is kept.

        Raises
        ------
        CommandError
            A velocity is not finite. A wrong shape is refused by the following ``step``; where
            sensors are read, at once.
        """
        if not isinstance(velocities, np.ndarray) or velocities.dtype.kind != "f":
            velocities = np.asarray(velocities, dtype=float)
        require_finite(velocities)
        if self._sensors is not None:
            velocities = self._as_with_sensors(ids, velocities)
        self._arena.commands = velocities

    def _as_with_sensors(self, ids: Any, velocities: Array) -> Array:
        """Commands (2, N) of all robots, as the release that came with sensors takes some."""
        limits = np.array([[self.max_linear_velocity], [self.max_angular_velocity]])
        commands: Array = self._arena.commands.copy()
        try:
            commands[:, ids] = np.clip(velocities, -limits, limits)
        except (IndexError, ValueError) as error:
            raise CommandError(
                f"velocities have shape {np.shape(velocities)} for the robots {ids!r}, expected "
                f"(2, {np.size(ids)}) and robots 0 to {self.number_of_robots - 1}"
            ) from error
        return commands

    @abstractmethod
    def get_poses(self) -> Array:
        """Poses (3, N) as tracked."""

    @abstractmethod
    def step(self) -> None:
        """Drive for one time step."""

    def _uni_to_diff(self, dxu: Array) -> Array:
        return self._obey_constants().wheels(dxu)

    def _diff_to_uni(self, dxdd: Array) -> Array:
        return self._obey_constants().unicycle(dxdd)

    def _threshold(self, dxu: Array) -> Array:
        return self._obey_constants().saturate(dxu)

    def _validate(self, errors: dict[str, Any] = {}) -> dict[str, Any]:  # noqa: B006 - never changed
        self._obey_constants().check()
        return {**errors, **self._errors}


def _check(number_of_robots: Any, show_figure: Any, sim_in_real_time: Any) -> None:
    """Refuse what no Robotarium can be made of."""
    if not isinstance(number_of_robots, int):
        raise ConstructorError(
            f"number_of_robots is {number_of_robots!r} ({type(number_of_robots).__name__}), "
            "expected an int from 1 to 50"
        )
    if not 1 <= number_of_robots <= 50:
        raise ConstructorError(f"number_of_robots is {number_of_robots}, expected 1 to 50")
    for name, flag in (("show_figure", show_figure), ("sim_in_real_time", sim_in_real_time)):
        if not isinstance(flag, bool):
            raise ConstructorError(f"{name} is {flag!r}, expected True or False")
