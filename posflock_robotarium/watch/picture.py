"""What a page is shown of one step: where robots are, who sees whom, what held them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.hearing import Answer
from posflock_robotarium.flocking.pose_log import INTERVENED
from rps_compat.arena import Arena

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class BarrierPicture:
    """What a certificate did in a step.

    Attributes
    ----------
    status : str
        What became of the command.
    intervention, clearance : float or None
        How far it changed a velocity at most, m/s; how far the team is from being unsafe, m. None
        is unknown.
    active : list of str
        What bound, in words.
    pairs : list of pair of int
        Robots that it kept apart from each other.
    held : list of int
        Robots whose velocity it changed.
    asked, given : list of list of float
        Velocities of those robots, x and y, as asked for and as admitted, m/s.
    """

    status: str
    intervention: float | None
    clearance: float | None
    active: list[str]
    pairs: list[tuple[int, int]]
    held: list[int]
    asked: list[list[float]]
    given: list[list[float]]


def barrier_of(answer: Answer) -> BarrierPicture:
    """Return what a page is shown of a certificate's answer.

    Parameters
    ----------
    answer : Answer
        As it was heard.
    """
    info, robots = answer.info, answer.desired.shape[1]
    changed = np.hypot(*(answer.velocity - answer.desired))
    held = np.flatnonzero(changed > INTERVENED)
    pairs, active = [], []
    if info.rows is not None and held.size:
        for row in info.binding.tolist():
            touched = sorted({int(k) // 2 for k in info.rows.index[:, row] if k < 2 * robots})
            label = info.rows.label(row)
            if len(touched) == 2:
                pairs.append((touched[0], touched[1]))
            if len(touched) == 2 or " and " in label:  # motors' limits keep nobody apart
                active.append(label)
    return BarrierPicture(
        status=info.status.value,
        intervention=known(info.intervention),
        clearance=known(info.clearance),
        active=list(dict.fromkeys(active)),  # a link has two rows
        pairs=list(dict.fromkeys(pairs)),
        held=held.tolist(),
        asked=rounded(answer.desired[:, held]),
        given=rounded(answer.velocity[:, held]),
    )


def scene_of(arena: Arena) -> dict[str, Any]:
    """Return what does not change from step to step.

    Parameters
    ----------
    arena : Arena
        Where the robots drive.
    """
    robot = arena.robot
    return {
        "robots": arena.number_of_robots,
        "arena": list(robot.boundaries),
        "collision": [robot.collision_diameter, robot.collision_offset],
        "time_step": robot.time_step,
    }


def frame_of(arena: Arena, leds: Floats | None) -> dict[str, Any]:
    """Return what is seen of the robots at the beginning of a step.

    Parameters
    ----------
    arena : Arena
        As it is now.
    leds : (3, N) array or None
        Red, green and blue of the robots' LEDs; None where nobody knows.
    """
    faults = arena.violations.lasting(max(arena.steps - 1, 1))
    return {
        "step": arena.steps,
        "time": round(arena.time, 4),
        "driving_to_start": arena.driving_to_start,
        "poses": rounded(arena.poses, 4),
        "commands": rounded(arena.commands),
        "leds": colours(leds),
        "faults": [
            {"kind": fault.kind.value, "robots": list(fault.robots)}
            for fault in faults
            if fault.kind.value != "actuator"
        ],
        "collisions": arena.violations.close_pairs,
        "outside": arena.violations.outside_steps,
    }


def colours(leds: Floats | None) -> list[str | None]:
    """Return the colours of LEDs as a page writes them; None for one that is off.

    Parameters
    ----------
    leds : (3, N) array or None
        Red, green and blue of each robot, parts from 0 to 1, or from 0 to 255.
    """
    if leds is None:
        return []
    found: list[str | None] = []
    for led in np.nan_to_num(np.asarray(leds, dtype=float)).T:
        scale = 1.0 if led.max(initial=0.0) > 1.0 else 255.0
        red, green, blue = (int(part) for part in np.clip(scale * led, 0, 255).round())
        found.append(f"#{red:02x}{green:02x}{blue:02x}" if red or green or blue else None)
    return found


def rounded(values: Floats, digits: int = 4) -> list[Any]:
    """Return an array as lists of numbers that are short in JSON; what is not finite is None.

    Parameters
    ----------
    values : (..., N) array
        Numbers of robots.
    digits : int
        Behind the point.
    """
    array = np.asarray(values, dtype=float).round(digits)
    if np.isfinite(array).all():
        return list(array.tolist())
    return [rounded(row) if isinstance(row, np.ndarray) else known(float(row)) for row in array]


def known(value: float) -> float | None:
    """Return a number, or None where it is not finite.

    Parameters
    ----------
    value : float
        A number, NaN or infinite where it is unknown.
    """
    return round(value, 5) if math.isfinite(value) else None
