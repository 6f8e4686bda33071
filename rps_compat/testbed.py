"""The real testbed as data: its robots, what it accepts, where its limits are.

The arena, and everything that judges a log or a submission, take the constants of both generations
from here; the two faces of the API publish them under names of their own.  They were read in the
Robotarium's published guide, simulators and firmware, and in logs that users published in 2026.
What is installed there stands in :mod:`rps_compat.scripts.libraries`.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class RobotModel:
    """Dimensions and limits of one kind of robot and its arena.

    Lengths in metres, speeds in metres or radians per second; the wheel limit in radians per
    second of the wheel. `boundaries` is (x_min, x_max, y_min, y_max).

    Attributes
    ----------
    wheel_radius : float
        Radius of the wheels, m.
    base_length : float
        From wheel to wheel, m.
    max_wheel_velocity : float
        Fastest that a wheel turns, rad/s.
    collision_diameter : float
        Two robots collide where their collision points are nearer than this, m.
    collision_offset : float
        How far ahead of the pose the collision point lies, m.
    time_step : float
        Duration of a step, s.
    boundaries : (x_min, x_max, y_min, y_max)
        The arena, m.
    """

    wheel_radius: float
    base_length: float
    max_wheel_velocity: float
    collision_diameter: float
    collision_offset: float
    time_step: float
    boundaries: tuple[float, float, float, float]


#: The robot of generation 1 of the testbed.
GRITSBOT_X = RobotModel(0.016, 0.105, 12.5, 0.135, 0.025, 0.033, (-1.6, 1.6, -1.0, 1.0))
#: The robot of generation 2.
GTERNAL = RobotModel(0.016, 0.11, 12.5, 0.135, 0.025, 0.033, (-1.6, 1.6, -1.0, 1.0))

#: Endings that may be uploaded.
ENDINGS = (
    ".py .m .mat .npy .jpg .jpeg .png .gif .tiff .bmp .mexa64".split()  # noqa: SIM905
)

#: Size of a robot's body along and across its heading, as it is drawn, metres.
ROBOT_LENGTH, ROBOT_WIDTH = 0.10, 0.11
MAX_ROBOTS = 20
#: Seconds after which any experiment ends.
MAX_DURATION = 900.0
#: A run that takes this many times its declared duration is refused.
OVERRUN = 1.5
TIME_STEP = GTERNAL.time_step
#: Seconds without a command after which a robot brakes.
WATCHDOG = 0.5
#: Advice for the distance of two robots' centres, metres.
SPACING = 0.15
#: Violations of a kind beyond which the published verifiers refuse a script.
TOLERATED_VIOLATIONS = 100
