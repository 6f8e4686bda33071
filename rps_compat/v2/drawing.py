"""What generation 2 shows of its arena: walls, obstacles, robots, and what their sensors read."""

from typing import TYPE_CHECKING, Any

import numpy as np

from rps_compat.arena import Array
from rps_compat.v2.patch_creation.gternal_patch import GTERNALRobotPatch, gternal_patch

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection


class GternalDrawing:
    """Everything that an instance of generation 2 has on its axes.

    Parameters
    ----------
    axes : Axes
        Where it is drawn.
    arena : Arena
        The simulated testbed whose robots are followed.
    boundaries : (4,) array or None
        x_min, x_max, y_min, y_max, m; None draws no walls.
    obstacles : (M, 2, 2) array or None
        Segments to be drawn, m; None draws none.
    colors : (N, 4) array
        A colour for each robot: its sensor rays and endpoints.
    patches, endpoints, rays : bool
        Whether robots, sensor endpoints and sensor rays are drawn.
    """

    def __init__(
        self,
        axes: "Axes",
        arena: Any,
        *,
        boundaries: Array | None,
        obstacles: Array | None,
        colors: Array,
        patches: bool,
        endpoints: bool,
        rays: bool,
    ) -> None:
        from matplotlib.lines import Line2D
        from matplotlib.patches import Rectangle

        self._arena = arena
        self._leds: Array = np.zeros((3, arena.number_of_robots))
        if boundaries is not None:
            x_min, x_max, y_min, y_max = boundaries
            size = (x_max - x_min, y_max - y_min)
            axes.add_patch(
                Rectangle((x_min, y_min), *size, fill=False, edgecolor="black", linewidth=3)
            )
        if obstacles is not None:
            for (x0, y0), (x1, y1) in np.asarray(obstacles, dtype=float).reshape(-1, 2, 2):
                axes.add_line(Line2D([x0, x1], [y0, y1], color="black", linewidth=2))
        data = gternal_patch()
        poses = arena.poses
        self.robots = [GTERNALRobotPatch(axes, pose, data) for pose in poses.T] if patches else []
        self.rays: list[list[Line2D]] = []
        if rays:
            self.rays = [
                [Line2D([], [], color=color, linewidth=0.8, alpha=0.6) for _ in range(7)]
                for color in colors
            ]
            for lines in self.rays:
                for line in lines:
                    axes.add_line(line)
        self.endpoints: list[PathCollection] = []
        if endpoints:
            self.endpoints = [axes.scatter([], [], s=12, color=color, zorder=4) for color in colors]

    def follow_robots(self, leds: Array) -> None:
        """Move the robots' patches to where the robots are, and colour their LEDs.

        Parameters
        ----------
        leds : (3, N) array
            Red, green and blue of each robot.
        """
        poses = self._arena.poses
        for robot, patch in enumerate(self.robots):
            patch.set_pose(poses[:, robot])
            if not np.array_equal(leds[:, robot], self._leds[:, robot]):
                patch.set_led(leds[:, robot])
        self._leds = np.array(leds)

    def follow_endpoints(self, ends: Array) -> None:
        """Move the dots to what the sensors read.

        Parameters
        ----------
        ends : (2, S, N) array
            The points, m; NaN where they read nothing.
        """
        for robot, dots in enumerate(self.endpoints):
            read = ends[:, :, robot].T
            dots.set_offsets(read[np.isfinite(read).all(axis=1)])

    def follow_rays(self, ends: Array, starts: Array) -> None:
        """Draw the rays from the sensors to what they read.

        Parameters
        ----------
        ends : (2, S, N) array
            What they read, m; NaN for nothing.
        starts : (2, S, N) array
            Where the sensors are, m.
        """
        for robot, lines in enumerate(self.rays):
            for sensor, line in enumerate(lines):
                line.set_data(
                    [starts[0, sensor, robot], ends[0, sensor, robot]],
                    [starts[1, sensor, robot], ends[1, sensor, robot]],
                )
