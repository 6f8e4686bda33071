"""A GTernal robot as a drawing: an outline in the robot's frame, and the patches that follow it."""

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Optional

import numpy as np
from numpy.typing import NDArray

from rps_compat.lazy import LazyModule

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

plt = LazyModule("matplotlib.pyplot")

# Scripts get these names from `import *`, so every one of them is part of the interface.
__all__ = [
    "GTERNALPatchData", "GTERNALRobotPatch", "NDArray", "Optional", "Path", "PathPatch",
    "dataclass", "gternal_patch", "np", "plt",
]  # fmt: skip

_BODY, _WHEEL, _LED_OFF = (0.36, 0.40, 0.46), (0.13, 0.14, 0.16), (0.93, 0.80, 0.35)
_LED = 3  # the face whose colour the LED sets


def __getattr__(name: str) -> Any:
    # matplotlib's classes belong to this module's names, and are imported when asked for.
    if name == "Path":
        from matplotlib.path import Path

        return Path
    if name == "PathPatch":
        from matplotlib.patches import PathPatch

        return PathPatch
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


@dataclass
class GTERNALPatchData:
    """Outline of a robot.

    Attributes
    ----------
    vertices : (V, 2) array
        Points in the robot's frame, m: forward, left.
    faces : list of list of int
        Indices into `vertices`, one list for each face, drawn in this order.
    colors : (F, 3) array
        Colours of the faces, parts from 0 to 1.
    """

    vertices: NDArray[np.floating]
    faces: list[list[int]]
    colors: NDArray[np.floating]


def gternal_patch() -> GTERNALPatchData:
    """Outline of a GTernal: two wheels, a body 11 cm across with a flat front, an LED ahead."""
    around = np.linspace(np.deg2rad(40), np.deg2rad(320), 25)
    body = 0.055 * np.column_stack([np.cos(around), np.sin(around)])
    body[:, 0] += 0.01
    wheel = np.array([[-0.016, -0.004], [0.016, -0.004], [0.016, 0.004], [-0.016, 0.004]])
    aside = np.array([0, 0.055])
    left, right = wheel + aside, wheel - aside
    lamp = np.linspace(0, 2 * np.pi, 13)[:-1]
    led = np.column_stack([0.033 + 0.012 * np.cos(lamp), 0.012 * np.sin(lamp)])
    parts = (left, right, body, led)
    starts = np.cumsum([0, *(len(part) for part in parts)])
    faces = [list(range(a, b)) for a, b in pairwise(starts)]
    colors = np.array([_WHEEL, _WHEEL, _BODY, _LED_OFF])
    return GTERNALPatchData(np.vstack(parts), faces, colors)


class GTERNALRobotPatch:
    """Patches of one robot on `axes`.

    Parameters
    ----------
    axes : Axes
        Where they are drawn.
    pose : (3,) array
        x and y, m, and heading, rad.
    patch_data : GTERNALPatchData, optional
        Outline; by default :func:`gternal_patch`.
    """

    def __init__(
        self,
        axes: "Axes",
        pose: NDArray[np.floating],
        patch_data: Optional[GTERNALPatchData] = None,  # noqa: UP045 - the published annotation
    ) -> None:
        from matplotlib.patches import PathPatch
        from matplotlib.path import Path

        self.data = gternal_patch() if patch_data is None else patch_data
        outline = self._transform(self.data.vertices, pose)
        self.patches = []
        for face, color in zip(self.data.faces, self.data.colors, strict=True):
            path = Path(_closed(outline[face]), closed=True)
            patch = PathPatch(path, facecolor=color, edgecolor="black", linewidth=0.5, zorder=3)
            axes.add_patch(patch)
            self.patches.append(patch)

    @staticmethod
    def _transform(
        body_verts: NDArray[np.floating], pose: NDArray[np.floating]
    ) -> NDArray[np.floating]:
        x, y, theta = np.asarray(pose, dtype=float).ravel()
        cosine, sine = np.cos(theta), np.sin(theta)
        rotation = np.array([[cosine, sine], [-sine, cosine]])
        placed: NDArray[np.floating] = body_verts @ rotation + np.array([x, y])
        return placed

    def set_pose(self, pose: NDArray[np.floating]) -> None:
        """Move the patches.

        Parameters
        ----------
        pose : (3,) array
            x and y, m, and heading, rad.
        """
        outline = self._transform(self.data.vertices, pose)
        for face, patch in zip(self.data.faces, self.patches, strict=True):
            vertices = np.asarray(patch.get_path().vertices)  # a view: the path's own points
            vertices[:] = _closed(outline[face])
            patch.stale = True

    def set_led(self, rgb: NDArray[np.floating]) -> None:
        """Colour the LED.

        Parameters
        ----------
        rgb : (3,) array
            Red, green and blue, parts from 0 to 1, or from 0 to 255.
        """
        color = np.asarray(rgb, dtype=float).ravel()
        scale = 255.0 if color.max(initial=0.0) > 1 else 1.0
        self.patches[_LED].set_facecolor(tuple(np.clip(color / scale, 0, 1)))

    def set_zorder(self, zorder: int) -> None:
        """Draw the robot above everything that is lower.

        Parameters
        ----------
        zorder : int
            How high, as for matplotlib's artists.
        """
        for patch in self.patches:
            patch.set_zorder(zorder)


def _closed(outline: NDArray[np.floating]) -> NDArray[np.floating]:
    closed: NDArray[np.floating] = np.vstack([outline, outline[:1]])
    return closed
