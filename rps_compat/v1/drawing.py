"""How generation 1 draws a GRITSBot X: a chassis, two wheels and two LEDs that follow the robot."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from rps_compat.arena import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CHASSIS, WHEEL, EDGE = "#e8c547", "#2b2d33", "#4a4a4a"
LED_LEFT, LED_RIGHT = "#d7263d", "#2a9d4a"


class GritsbotPatches:
    """Patches of all robots on one axes.

    Parameters
    ----------
    axes
        Where they are drawn.
    poses
        Gives the present poses (3, N).
    length, width
        Size of a chassis, metres.
    boundaries
        x, y, width and height of the arena, metres.
    """

    def __init__(
        self,
        axes: "Axes",
        poses: Callable[[], Array],
        length: float,
        width: float,
        boundaries: list[float],
    ) -> None:
        from matplotlib.patches import Circle, Rectangle

        self._poses, self._length, self._width = poses, length, width
        x, y, w, h = boundaries
        self.boundary = Rectangle((x, y), w, h, fill=False, edgecolor="black", linewidth=2)
        axes.add_patch(self.boundary)
        robots = range(poses().shape[1])
        self.left_wheels = [Circle((0, 0), 0.02, color=WHEEL) for _ in robots]
        self.right_wheels = [Circle((0, 0), 0.02, color=WHEEL) for _ in robots]
        self.chassis = [
            Rectangle((0, 0), length, width, facecolor=CHASSIS, edgecolor=EDGE) for _ in robots
        ]
        self.left_leds = [Circle((0, 0), 0.008, color=LED_LEFT) for _ in robots]
        self.right_leds = [Circle((0, 0), 0.008, color=LED_RIGHT) for _ in robots]
        for kind in (
            self.left_wheels,
            self.right_wheels,
            self.chassis,
            self.left_leds,
            self.right_leds,
        ):
            for patch in kind:
                axes.add_patch(patch)
        self.follow()

    def follow(self) -> None:
        """Move all patches to where the robots are."""
        x, y, theta = self._poses()
        ahead = np.array([np.cos(theta), np.sin(theta)])
        aside = np.array([-ahead[1], ahead[0]])
        centre = np.array([x, y])
        corner = centre - ahead * self._length / 2 - aside * self._width / 2
        for robot, patch in enumerate(self.chassis):
            patch.set_xy((corner[0, robot], corner[1, robot]))
            patch.set_angle(float(np.rad2deg(theta[robot])))
        places = (
            (self.left_wheels, centre + aside * self._width / 2),
            (self.right_wheels, centre - aside * self._width / 2),
            (self.left_leds, centre + ahead * self._length * 0.3 + aside * 0.018),
            (self.right_leds, centre + ahead * self._length * 0.3 - aside * 0.018),
        )
        for circles, at in places:
            for robot, circle in enumerate(circles):
                circle.set_center((at[0, robot], at[1, robot]))
