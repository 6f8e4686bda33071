"""From the options of a command to how a log is read: the same for every command that reads one."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from posflock_robotarium.logs.readers import ReadOptions


def reading(
    layout: str | None,
    columns: str | None,
    dt: float | None,
    array: str | None,
    drop_damaged: bool,
    units: str | None,
    degrees: bool,
    time: str,
    max_size: float,
    max_robots: int,
    arena: str | None,
    collision_diameter: float | None,
    fix_swaps: bool,
) -> ReadOptions:
    """Return what the user says about a file, from what was typed.

    Parameters
    ----------
    layout, columns : str or None
        How an array or a table lies.
    dt : float or None
        Seconds between samples.
    array : str or None
        Which array holds the poses.
    drop_damaged : bool
        Whether rows with numbers that are none are left out.
    units : str or None
        What lengths are in, a word of `Lengths`.
    degrees : bool
        Whether angles are in degrees.
    time : str
        Whose times are used, a word of `LogClock`.
    max_size : float
        MB that a log may take.
    max_robots : int
        Robots that it may have.
    arena : str or None
        Four numbers with commas between: left, right, bottom, top, m.
    collision_diameter : float or None
        Of the collision test, m.
    fix_swaps : bool
        Whether robots that are taken for each other get their own poses.

    Raises
    ------
    ParameterError
        Where a word or number is none of those that are expected.
    """
    from posflock_robotarium.flocking.errors import ParameterError
    from posflock_robotarium.logs.readers import Bounds, Lengths, LogClock, ReadOptions
    from posflock_robotarium.logs.robots import GivenRobot

    if units is not None and units not in (known := [length.value for length in Lengths]):
        raise ParameterError(f"--units {units!r} is none of {', '.join(known)}")
    if time not in (clocks := [clock.value for clock in LogClock]):
        raise ParameterError(f"--time {time!r} is none of {', '.join(clocks)}")
    return ReadOptions(
        layout,
        columns,
        dt,
        array,
        drop_damaged,
        Bounds(max_size, max_robots),
        LogClock(time),
        None if units is None else Lengths(units),
        degrees,
        GivenRobot(_rectangle(arena), collision_diameter),
        fix_swaps,
    )


def _rectangle(arena: str | None) -> tuple[float, float, float, float] | None:
    from posflock_robotarium.flocking.errors import ParameterError

    if arena is None:
        return None
    try:
        left, right, bottom, top = (float(edge) for edge in arena.split(","))
    except ValueError as error:
        raise ParameterError(
            f"--arena {arena!r}; expected left,right,bottom,top in metres, for example "
            "-1.6,1.6,-1,1"
        ) from error
    return left, right, bottom, top
