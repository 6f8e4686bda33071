"""Metres and radians, whatever the file has: told by its header, said by the user, or asked.

A position tells its unit by the arena: no robot is five arenas away from the middle of its own.
Rows that a logger wrote twice between two frames of the camera are dropped here, too: they are no
new poses, and a robot that jumps every fifth row is what they would look like.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.readers.heading_units import ask_where_degrees
from posflock_robotarium.logs.readers.names import ANGLES, LENGTHS
from posflock_robotarium.logs.robots import robot_of
from posflock_robotarium.logs.run import LayoutError

Floats = NDArray[np.float64]

ARENAS_AWAY = 5.0
"""Half widths of the arena from its middle beyond which most poses cannot be metres."""

SAME_FRAME = 0.01
"""Seconds within which an equal row is the same frame of the camera."""

_AT_ONCE = 0.25
"""Share of the usual time between new poses that this must be, too."""


def in_metres(found: Found, where: str, options: ReadOptions) -> Found:
    """Bring lengths to metres and angles to radians.

    Parameters
    ----------
    found : Found
        Poses and commands as the file has them.
    where : str
        File name for messages.
    options : ReadOptions
        Its ``units`` and ``degrees`` are for what the file does not say.

    Raises
    ------
    LayoutError
        Where nobody says the unit, and lengths cannot be metres in that arena.
    """
    if options.units is not None and not found.lengths_told:
        found = _scaled(found, 0, LENGTHS[options.units.value])
        found = found.noted(f"lengths in {options.units.value}, as asked")
    elif options.units is None and not found.lengths_told:
        _ask_where_too_far(found, where)
    else:
        told = found.lengths_told and options.units is not None
        found = found.noted("--units not used: the file says its own") if told else found
    if options.degrees and not found.angles_told:
        found = _scaled(found, 2, ANGLES["deg"]).noted("angles in degrees, as asked")
    elif options.degrees:
        found = found.noted("--degrees not used: the file says its own unit")
    elif not found.angles_told:
        ask_where_degrees(found, where)
    return found


def _scaled(found: Found, axis: int, factor: float) -> Found:
    """Scale positions and speeds (axis 0), or headings and turn rates (axis 2)."""
    if factor == 1.0:
        return found
    poses = np.array(found.poses, dtype=float)
    commands = None if found.commands is None else np.array(found.commands, dtype=float)
    poses[:, slice(0, 2) if axis == 0 else slice(2, 3)] *= factor
    if commands is not None:
        commands[:, 0 if axis == 0 else 1] *= factor
    return replace(found, poses=poses, commands=commands)


def _ask_where_too_far(found: Found, where: str) -> None:
    reach = max(map(abs, robot_of(found.parameters).model.boundaries))
    # Of each robot at each time: a marker for one that is lost is not where robots usually are.
    away = np.abs(found.poses[:, :2]).max(axis=1)
    moves = np.ones(away.shape, dtype=bool)
    moves[1:] = away[1:] != away[:-1]
    away = away[np.isfinite(away) & moves]
    usual = float(np.median(away)) if away.size else 0.0
    if usual > ARENAS_AWAY * reach:
        raise LayoutError(
            f"{where}: robots are {usual:.4g} from the middle of an arena that ends at {reach:g} m:"
            " what are lengths in? Say --units cm or --units mm, or --units m where they are metres"
        )


def without_repeats(found: Found, within: float = 0.0) -> Found:
    """Drop rows that say again what the row before them says, at nearly the same time.

    Parameters
    ----------
    found : Found
        Poses with times. A robot that stands still is left as it is.
    within : float
        How much later a row may be, in the file's unit of time.
    """
    if found.t is None or len(found.t) != len(found.poses) or len(found.t) < 3:
        return found
    with np.errstate(invalid="ignore", over="ignore"):
        equal = (np.diff(found.poses, axis=0) == 0).all(axis=(1, 2))
    same = np.concatenate([[False], equal])
    if not same.any() or same[1:].all():
        return found
    new = found.t[~same]
    with np.errstate(invalid="ignore", over="ignore"):
        usual = float(np.median(np.diff(new)))
        later = np.diff(found.t)
        at_once = (later >= 0) & (later <= min(within, _AT_ONCE * usual))
    repeated = same & np.concatenate([[False], at_once])
    if not repeated.any():
        return found
    told = f"{int(repeated.sum())} of {len(same)} rows repeat the one before them: dropped"
    return found.rows(~repeated).noted(told)
