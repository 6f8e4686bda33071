"""What every Robotarium of generation 2 has: constants, options, commands, wheels, validation."""

import math
import time
import weakref
from abc import ABC, abstractmethod
from functools import cache
from typing import TYPE_CHECKING, Any, Optional

import numpy as np
from numpy.typing import NDArray

from rps_compat import session
from rps_compat.arena import Arena, Array, require_finite
from rps_compat.errors import CommandError
from rps_compat.figure import ArenaFigure
from rps_compat.initial import checked_poses, drawn_poses, first_poses
from rps_compat.lazy import LazyModule
from rps_compat.pace import pace_of
from rps_compat.testbed import GTERNAL, RobotModel
from rps_compat.v2.constructor_options import ConstructorOptions
from rps_compat.v2.drawing import GternalDrawing
from rps_compat.v2.patch_creation.gternal_patch import GTERNALRobotPatch, gternal_patch
from rps_compat.v2.sensor_readings import SensorReadings
from rps_compat.v2.sensor_suite import SensorSuite
from rps_compat.wrong_generation import refuse

if TYPE_CHECKING:
    from matplotlib.lines import Line2D

plt = LazyModule("matplotlib.pyplot")
patches = LazyModule("matplotlib.patches")
_misc = LazyModule("rps_compat.v2.utilities.misc")

# Scripts get these names from `import *`, so every one of them is part of the interface.
__all__ = [
    "ABC", "ARobotarium", "GTERNALRobotPatch", "Line2D", "NDArray", "Optional", "abstractmethod",
    "gternal_patch", "math", "np", "patches", "plt",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    # matplotlib's class belongs to this module's names, and is imported when asked for.
    if name == "Line2D":
        from matplotlib.lines import Line2D

        return Line2D
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


#: Artists that exist only where their option is on.
_SENSOR_ARTISTS = {
    "_distance_endpoint_patches": "show_distance_endpoints",
    "_distance_ray_lines": "show_distance_rays",
}


class ARobotarium(SensorReadings):
    """The parts of a Robotarium that do not depend on where its robots are.

    Parameters
    ----------
    number_of_robots : int
        1 to 50.
    show_figure : bool
        Whether the arena is drawn, by default True. Without it no figure is made until
        ``_axes_handle`` or ``_fig`` is asked for.
    sim_in_real_time : bool
        Whether ``step`` waits for its slot of 33 ms (in a window), by default True.
    initial_conditions : (3, N) array
        Where the experiment begins, m and rad; left out, it is drawn at random.
    skip_initialization : bool
        Start there instead of driving there, by default False.
    use_distance_sensors : bool
        Simulate the seven infrared sensors, by default False.
    obstacles : (M, 2, 2) array
        Segments that the distance sensors see: end points, m.
    show_arena_boundaries, show_robot_patches, show_obstacles : bool
        What the figure shows, by default all.
    show_distance_endpoints, show_distance_rays : bool
        Whether the figure shows what the distance sensors hit (True) and the rays (False).

    Raises
    ------
    ConstructorError, InitialConditionsError
        What is wrong with the arguments, and what was expected.
    """

    TIME_STEP = GTERNAL.time_step
    MAX_LINEAR_VELOCITY = 0.2
    ROBOT_DIAMETER = 0.11
    WHEEL_RADIUS = GTERNAL.wheel_radius
    BASE_LENGTH = GTERNAL.base_length
    MAX_WHEEL_VELOCITY = GTERNAL.max_wheel_velocity
    MAX_ANGULAR_VELOCITY = 2 * (WHEEL_RADIUS / ROBOT_DIAMETER) * MAX_WHEEL_VELOCITY
    CENTER_OFFSET = 0.01
    COLLISION_OFFSET = GTERNAL.collision_offset
    COLLISION_DIAMETER = GTERNAL.collision_diameter
    BOUNDARIES: Array = np.array(GTERNAL.boundaries)

    ENCODER_COUNTS_PER_REVOLUTION = 28
    MOTOR_GEAR_RATIO = 100.37
    ENCODER_NOISE_STD = 0.25
    ACCELEROMETER_NOISE_STDS: Array = np.array([0.012929, 0.012127, 0.052979])
    GYRO_NOISE_STDS: Array = np.array([0.001663, 0.001216, 0.002372])
    MAGNETOMETER_NOISE_STDS: Array = np.array([3.275843, 2.365798, 5.232685])
    MAGNETOMETER_XY_AVG = 6.0712
    MAGNETOMETER_Z_AVG = -39.8594
    ORIENTATION_NOISE_STD = 0.31083
    IMU_ORIENTATION: Array = np.array([0.05621, -0.0130372, 0.0])
    DISTANCE_SENSORS_ORIENTATION: Array = np.array(
        [
            [-0.04, 0.0, 0.04, 0.05, 0.04, 0.0, -0.04],
            [0.04, 0.06, 0.05, 0.0, -0.05, -0.06, -0.04],
            [np.pi, np.pi / 2, np.pi / 4, 0.0, -np.pi / 4, -np.pi / 2, -np.pi],
        ]
    )
    DISTANCE_SENSOR_RANGE = 1.2
    DISTANCE_SENSOR_ERROR = 0.03
    DISTANCE_SENSOR_DROPOUT_PROB = 0.035
    DISTANCE_SENSOR_OUTLIER_PROB = 0.014

    def __init__(self, **kwargs: Any) -> None:
        options = ConstructorOptions.of(kwargs)
        options.check()
        robots = self.number_of_robots = int(options.number_of_robots)
        self.show_figure = options.show_figure
        self._sim_in_real_time = options.sim_in_real_time
        self.show_arena_boundaries = options.show_arena_boundaries
        self.show_distance_endpoints = options.show_distance_endpoints
        self.show_distance_rays = options.show_distance_rays
        self.show_obstacles = options.show_obstacles
        self.show_robot_patches = options.show_robot_patches
        self._distance_sensors_enabled = options.use_distance_sensors
        self.obstacles = options.obstacles

        self.initializing = False
        self._called_step_already = True
        self._checked_poses_already = False
        self._previous_render_time = time.time()
        self._leds = np.zeros((3, robots))
        self._velocities_old: Array = np.zeros((2, robots))

        self._session = session.current()
        self._random = cache(self._session.generator)  # one stream, drawn from only if needed
        self._model_key: tuple[Any, ...] = self._constants()
        self._targets = self._target(options.initial_conditions)
        self._mode = self._session.mode("exact" if options.skip_initialization else "drive")
        poses = first_poses(self._targets, self._mode, self._model(), self._random)
        self._arena = self._session.arena(poses, self._model(), self._random)
        self._suite = SensorSuite(self)
        self._initial_encoders = np.zeros((2, robots))
        self._picture: ArenaFigure | None = None
        self._drawing: GternalDrawing | None = None
        if self.show_figure:
            self._initialize_visualization()
        self._pace = pace_of(self._picture, self._sim_in_real_time, self._session)
        if self._session.created is not None:
            self._session.created(self)

    def _target(self, initial_conditions: Any) -> Array:
        robots = self.number_of_robots
        if isinstance(initial_conditions, tuple) and not initial_conditions:

            def draw(spacing: float) -> Array:
                poses: Array = _misc.generate_random_poses(
                    robots, spacing=spacing, width=2.75, height=1.75
                )
                return poses

            return drawn_poses(draw, 0.5, robots, self._model(), self._random)
        return checked_poses(initial_conditions, robots)

    def __getattr__(self, name: str) -> Any:
        if name in ("_fig", "_axes_handle", "_robot_handle", *_SENSOR_ARTISTS):
            option = _SENSOR_ARTISTS.get(name)
            if option and not (self.show_figure and getattr(self, option)):
                return refuse(self, name, generation=2)
            self._initialize_visualization()  # made when first asked for
            return self.__dict__[name]
        if name == "_distance_endpoints":
            raise AttributeError(
                "there are no distance endpoints without distance sensors: "
                "Robotarium(use_distance_sensors=True, ...)"
            )
        if name == "_cm":
            self._cm = self.robot_colormap().cmap
            return self._cm
        return refuse(self, name, generation=2)

    def _initialize_visualization(self) -> None:
        me = weakref.ref(self)

        def update() -> None:
            of = me()
            if of is not None:
                of._draw_robots()

        x_min, x_max, y_min, y_max = self.BOUNDARIES
        limits = (x_min - 0.05, x_max + 0.05, y_min - 0.05, y_max + 0.05)
        picture = self._picture = ArenaFigure(self, (8.25, 5.25), limits, update)
        self._fig, self._axes_handle = picture.figure, picture.axes
        sensors = self._distance_sensors_enabled
        rays, endpoints = (
            sensors and self.show_distance_rays,
            sensors and self.show_distance_endpoints,
        )
        self._drawing = GternalDrawing(
            picture.axes,
            self._arena,
            boundaries=self.BOUNDARIES if self.show_arena_boundaries else None,
            obstacles=self.obstacles if self.show_obstacles else None,
            colors=self._robot_colors() if rays or endpoints else np.empty((0, 4)),
            patches=self.show_robot_patches,
            endpoints=endpoints,
            rays=rays,
        )
        self._robot_handle = self._drawing.robots
        self._distance_endpoint_patches = self._drawing.endpoints
        self._distance_ray_lines = self._drawing.rays
        picture.show()

    def _draw_robots(self) -> None:
        drawing = self._drawing
        if drawing is None:
            return
        drawing.follow_robots(self._leds)
        if self._distance_sensors_enabled and (drawing.endpoints or drawing.rays):
            ends = self._distance_endpoints
            self._draw_distance_endpoints(ends)
            self._draw_distance_rays(ends)

    def _draw_distance_endpoints(self, endpoints: Array) -> None:
        if self._drawing is not None:
            self._drawing.follow_endpoints(endpoints)

    def _draw_distance_rays(self, endpoints: Array) -> None:
        if self._drawing is not None:
            starts = self._calculate_endpoints(np.zeros_like(self._distances))
            self._drawing.follow_rays(endpoints, starts)

    def robot_colormap(self) -> Any:
        """Colours of the robots, one each, as a matplotlib ScalarMappable of robot indices."""
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import ListedColormap, Normalize

        colors = ListedColormap(self._robot_colors())
        return ScalarMappable(Normalize(0, max(self.number_of_robots - 1, 1)), colors)

    def _robot_colors(self) -> Array:
        from matplotlib.colors import hsv_to_rgb

        # Steps of the golden ratio around the colour circle: neighbours differ for any number.
        hue = np.mod(np.arange(self.number_of_robots) * 0.618034, 1.0)
        rgb = hsv_to_rgb(np.column_stack([hue, np.full_like(hue, 0.75), np.full_like(hue, 0.85)]))
        return np.column_stack([rgb, np.ones_like(hue)])

    def _constants(self) -> tuple[Any, ...]:
        return (
            self.WHEEL_RADIUS,
            self.BASE_LENGTH,
            self.MAX_WHEEL_VELOCITY,
            self.COLLISION_DIAMETER,
            self.COLLISION_OFFSET,
            self.TIME_STEP,
            id(self.BOUNDARIES),
        )

    def _model(self) -> RobotModel:
        wheel, base, limit, diameter, offset, step, _ = self._constants()
        x_min, x_max, y_min, y_max = (float(edge) for edge in self.BOUNDARIES)
        edges = (x_min, x_max, y_min, y_max)
        return RobotModel(wheel, base, limit, diameter, offset, step, edges)

    def _obey_constants(self) -> Arena:
        constants = self._constants()
        if constants != self._model_key:
            self._model_key, self._arena.robot = constants, self._model()
        return self._arena

    @property
    def _poses(self) -> Array:
        return self._arena.poses

    @_poses.setter
    def _poses(self, poses: Array) -> None:
        self._arena.place(checked_poses(np.asarray(poses), self.number_of_robots))

    @property
    def _velocities(self) -> Array:
        return self._arena.commands

    @_velocities.setter
    def _velocities(self, velocities: Array) -> None:
        self._arena.commands = velocities

    @property
    def _iteration(self) -> int:
        return self._arena.steps

    @property
    def _errors(self) -> dict[str, int]:
        found = self._arena.violations
        counts = {
            "robots_outside_boundaries": found.outside_steps,
            "robots_too_close": found.close_pairs,
            "exceeded_actuator_limits": found.saturated_steps,
        }
        return {kind: count for kind, count in counts.items() if count}

    @_errors.setter
    def _errors(self, errors: dict[str, int]) -> None:
        # Scripts that copy the published step write `self._errors = self._validate(...)`, and
        # those that start counting afresh write {}.
        if not errors:
            self._arena.forget_violations()

    def set_velocities(self, ids: NDArray[np.integer], velocities: Array) -> None:
        """Command some robots, from the next step on; the others keep what they have.

        Parameters
        ----------
        ids : (M,) integer array
            Which robots.
        velocities : (2, M) array
            Their forward speeds, m/s, and turn rates, rad/s. Copied.

        Raises
        ------
        CommandError
            No such robot, a wrong shape, or a velocity that is not finite: with robot and value.
        """
        given = np.asarray(velocities, dtype=float)
        if given.ndim != 2 or given.shape[0] != 2:
            raise CommandError(
                f"velocities have shape {given.shape}, expected (2, {np.size(ids)}): a row of "
                "forward speeds in m/s, a row of turn rates in rad/s"
            )
        require_finite(given)
        try:
            self._arena.commands[:, ids] = given
            self._arena.commanded = True
        except IndexError as error:
            raise CommandError(
                f"ids are {ids!r}, but there are robots 0 to {self.number_of_robots - 1}"
            ) from error
        except ValueError as error:
            raise CommandError(
                f"velocities have shape {given.shape} for {np.size(ids)} robots, expected "
                f"(2, {np.size(ids)})"
            ) from error

    @abstractmethod
    def get_poses(self) -> Array:
        """Poses (3, N) as tracked."""

    @abstractmethod
    def initialize(self, initial_conditions: Array) -> None:
        """Bring the robots to where the experiment begins.

        Parameters
        ----------
        initial_conditions : (3, N) array
            Their poses there, m and rad.
        """

    @abstractmethod
    def step(self) -> None:
        """Drive for one time step."""

    @abstractmethod
    def debug(self) -> None:
        """Print what the testbed would say about this run."""

    def _uni_to_diff(self, dxu: Array) -> Array:
        return self._obey_constants().wheels(dxu)

    def _diff_to_uni(self, dxdd: Array) -> Array:
        return self._obey_constants().unicycle(dxdd)

    def _threshold(self, dxu: Array) -> Array:
        return self._obey_constants().saturate(dxu)

    def _validate(self, errors: dict[str, int]) -> dict[str, int]:
        self._obey_constants().check()
        return {**errors, **self._errors}
