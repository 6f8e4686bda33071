"""Headings that cannot be radians: found out by how wheels roll, and by how a log begins.

Headings in degrees look like radians to a program: numbers that rise and fall. But robots roll
where they head, so that where they slide in radians and roll in degrees, degrees it is; and no
tracker begins with a heading beyond four turns. Nothing is converted unasked: it is a question.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.logs.readers.found import Found
from posflock_robotarium.logs.readers.rolling import FAR, ROLLING, moved_far, sideways_share
from posflock_robotarium.logs.run import LayoutError

Floats = NDArray[np.float64]

_SLIDES_ANYHOW = 0.1
"""Share of sideways motion that is no noise, beyond five times that of the other reading."""

_NO_PLACE = 100.0
"""Metres from the middle of the arena at which no robot is seen."""

_FOUR_TURNS = 8 * math.pi
"""Radians, beyond which no log begins, wherever its turns are counted from."""


def ask_where_degrees(found: Found, where: str) -> None:
    """Ask what headings are in, where robots roll along them only in degrees or by a compass.

    Parameters
    ----------
    found : Found
        Poses in metres, whose headings nobody has said the unit of.
    where : str
        File name for messages.

    Raises
    ------
    LayoutError
        Where they are something else than radians counterclockwise from the x axis.
    """
    poses = found.poses
    headings = poses[:, 2]
    if not np.isfinite(headings).any():
        return
    with np.errstate(all="ignore"):
        as_they_are = sideways_share(poses)
        moves = moved_far(poses) > FAR
    if moves and as_they_are > _SLIDES_ANYHOW:
        for reading, (scale, offset, said) in _READINGS.items():
            read = poses.copy()
            read[:, 2] = offset + scale * headings
            with np.errstate(all="ignore"):
                share = sideways_share(read)
            if share < ROLLING and as_they_are > 5 * share + _SLIDES_ANYHOW:
                raise LayoutError(
                    f"{where}: headings are {reading}: only so do robots roll where they head "
                    f"({share:.0%} of their motion is sideways, as radians {as_they_are:.0%}); "
                    + said
                )
    # A marker for a robot that is lost is no heading, and its place is one, too.
    with np.errstate(invalid="ignore"):
        there = np.isfinite(headings) & (np.abs(poses[:, :2]) < _NO_PLACE).all(axis=1)
    first = np.argmax(there, axis=0), np.arange(headings.shape[1])
    begins = np.where(there[first], np.abs(headings[first]), 0.0)
    if begins.max() > _FOUR_TURNS:
        raise LayoutError(
            f"{where}: robot {int(begins.argmax())} begins with a heading of {begins.max():.4g}, "
            "more than four turns of 6.28 rad: say --degrees where these are degrees, or write "
            "them within ±π"
        )


_DEGREE = math.pi / 180
_READINGS: dict[str, tuple[float, float, str]] = {
    "degrees": (_DEGREE, 0.0, "say --degrees, or write its unit into the header (theta_deg)"),
    "degrees clockwise from the y axis, as a compass has them": (
        -_DEGREE,
        math.pi / 2,
        "write 90 - heading, and say --degrees",
    ),
    "clockwise from the y axis, as a compass has them": (
        -1.0,
        math.pi / 2,
        "write π/2 - heading in their place",
    ),
}
"""What headings may be instead: factor, offset (rad), and what to do about it."""
