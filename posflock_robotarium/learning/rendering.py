"""A team in its arena as a picture: what ``render_mode="rgb_array"`` shows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.figures.palette import BLACK, BLUE, GREEN, GREY, ORANGE
from posflock_robotarium.figures.style import in_style, new_figure
from posflock_robotarium.learning.scenario import Marker, World
from posflock_robotarium.learning.teams import Teams
from rps_compat.testbed import ROBOT_LENGTH, ROBOT_WIDTH

__all__ = ["ArenaPicture", "TeamPictures"]

Picture = NDArray[np.uint8]

_WIDTH, _HEIGHT, _DPI = 5.6, 3.6, 100
_COLOURS = {"goal": GREEN, "hidden": GREY, "found": ORANGE, "sensing": BLUE, "capture": ORANGE}


class ArenaPicture:
    """Draws teams of one size into one arena, again and again.

    Parameters
    ----------
    boundaries : (4,) tuple
        Least x, greatest x, least y, greatest y, m.
    """

    @in_style
    def __init__(self, boundaries: tuple[float, float, float, float]) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        self._figure = new_figure(_WIDTH, _HEIGHT)
        self._figure.set_dpi(_DPI)
        canvas: Any = FigureCanvasAgg(self._figure)  # matplotlib leaves it untyped
        self._canvas = canvas
        self._axes = self._figure.add_subplot()
        left, right, bottom, top = boundaries
        corners_x = [left, right, right, left, left]
        self._axes.plot(corners_x, [bottom, bottom, top, top, bottom], color=BLACK, linewidth=1.0)
        self._axes.set(xlim=(left - 0.06, right + 0.06), ylim=(bottom - 0.06, top + 0.06))
        self._axes.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
        for spine in self._axes.spines.values():
            spine.set_visible(False)
        self._axes.set_title("t = 0.0 s", fontsize=8)
        canvas.draw()
        self._figure.set_layout_engine("none")  # laid out once: nothing jumps from frame to frame

    @in_style
    def draw(self, world: World, team: int, marks: tuple[Marker, ...]) -> Picture:
        """Return the picture of a team now.

        Parameters
        ----------
        world : World
            All teams.
        team : int
            Which of them.
        marks : tuple of Marker
            What the scenario has in the arena beside robots.

        Returns
        -------
        (360, 560, 3) array
            Red, green and blue bytes.
        """
        from matplotlib.patches import Circle, Polygon

        drawn: list[Any] = []
        for mark in marks:
            colour = _COLOURS[mark.kind]
            place = (mark.x, mark.y)
            if mark.radius > 0.0:
                ring = Circle(place, mark.radius, facecolor=colour, alpha=0.12, zorder=0)
                drawn.append(self._axes.add_patch(ring))
            else:
                shape = "x" if mark.kind == "goal" else "o"
                drawn += self._axes.plot(*place, shape, color=colour, markersize=7, zorder=1)
            if mark.label:
                drawn.append(self._beside(place, mark.label, colour, (4, 3)))
        poses = world.true_poses[team]
        for robot, (x, y, heading) in enumerate(poses.T):
            body, nose = _outline(x, y, heading)
            outline = Polygon(body, facecolor=BLUE, edgecolor=BLACK, linewidth=0.5, zorder=2)
            arrow = Polygon(nose, facecolor="white", zorder=3)
            drawn += [self._axes.add_patch(outline), self._axes.add_patch(arrow)]
            drawn.append(self._beside((x, y), str(robot), BLACK, (7, 7)))
        self._axes.set_title(f"t = {world.time[team]:.1f} s", fontsize=8)
        self._canvas.draw()
        picture: Picture = np.asarray(self._canvas.buffer_rgba())[..., :3].copy()
        for artist in drawn:
            artist.remove()
        return picture

    def _beside(
        self, place: tuple[float, float], words: str, colour: str, points: tuple[int, int]
    ) -> Any:
        return self._axes.annotate(
            words, place, points, textcoords="offset points", color=colour, fontsize=7
        )


class TeamPictures:
    """Pictures of teams as they are, drawn into one figure that is made at the first.

    Parameters
    ----------
    teams : Teams
        Who is drawn.
    """

    def __init__(self, teams: Teams) -> None:
        self._teams = teams
        self._picture: ArenaPicture | None = None

    def of(self, team: int) -> Picture:
        """Return the arena from above.

        Parameters
        ----------
        team : int
            Whose.

        Returns
        -------
        (360, 560, 3) array
            Red, green and blue bytes.
        """
        if self._picture is None:
            self._picture = ArenaPicture(self._teams.settings.robot.boundaries)
        world = self._teams.world
        return self._picture.draw(world, team, self._teams.scenario.marks(world, team))


def _outline(x: float, y: float, heading: float) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the corners of a robot's body, and of the arrowhead in it, (K, 2) each."""
    half = np.array([ROBOT_LENGTH, ROBOT_WIDTH]) / 2.0
    turn = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
    body = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    nose = np.array([[0.9, 0.0], [-0.7, 0.75], [-0.35, 0.0], [-0.7, -0.75]]) * half
    return body @ turn + (x, y), nose @ turn + (x, y)
