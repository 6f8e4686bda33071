"""The summary's scalars: each with its unit and a definition that says exactly what was taken."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.alignment.curves import Curves
from posflock_robotarium.alignment.estimators import expected_bias, tracking_noise
from posflock_robotarium.flocking.pose_log import INTERVENED
from posflock_robotarium.logs.readers import Run
from rps_compat.testbed import RobotModel

Floats = NDArray[np.float64]

FEWEST_COUNTED = 0.005
"""Share of robots and time that a mean γ must rest on, lest noise speak for a parked flock."""

STALL_COMMAND = 0.02
"""Commanded speed in m/s above which a standing robot stalls."""

LAST_SHARE = 0.1
"""How much of a run is its end: long enough that a script's own last stop is not parking."""

STALL_SECONDS = 1.0
"""Seconds a robot must stand against its command; the testbed's dead time is 0.2 s."""


@dataclass(frozen=True)
class Number:
    """One scalar of the summary.

    Attributes
    ----------
    label : str
        Words for people.
    value : float
        NaN where undefined.
    unit : str
        Empty for pure numbers.
    definition : str
        What exactly was taken.
    group : str
        Table of the summary that it belongs to.
    """

    label: str
    value: float
    unit: str
    definition: str
    group: str


@dataclass(frozen=True, eq=False)
class Situation:
    """Everything the numbers are taken from.

    Attributes
    ----------
    recording : Run
        Poses over time.
    curves : Curves
        Every quantity over time.
    robot : RobotModel
        Collision test, wheels and arena of the testbed.
    settled : (T,) boolean array
        Samples that count for the numbers named "settled".
    slowest : float
        Speed up to which a robot has no direction of motion, m/s.
    threshold : float
        γ from which the flock counts as aligned.
    window : float
        Length of the Savitzky-Golay window, s.
    """

    recording: Run
    curves: Curves
    robot: RobotModel
    settled: NDArray[np.bool_]
    slowest: float
    threshold: float
    window: float


class _Add(Protocol):
    """Takes a number into the table of its group."""

    def __call__(self, key: str, label: str, value: float, unit: str, definition: str) -> None: ...


def numbers_of(s: Situation) -> dict[str, Number]:
    """Return every number that the recording has data for, in the order of the summary table.

    Parameters
    ----------
    s : Situation
        Run, curves and options.

    Returns
    -------
    dict of Number
        By key; NaN where a number is undefined (γ of a flock that stands, say).
    """
    found: dict[str, Number] = {}
    for group, part in _GROUPS.items():

        def add(
            key: str, label: str, value: float, unit: str, definition: str, group: str = group
        ) -> None:
            found[key] = Number(label, value, unit, definition, group)

        part(s, add)
    return found


def _run(s: Situation, add: _Add) -> None:
    r = s.recording
    gaps = r.gaps
    lost = float((r.t[gaps] - r.t[gaps - 1]).sum()) if gaps.size else 0.0
    add("robots", "robots", r.robots, "", "Robots in the log.")
    add("duration", "duration", float(r.t[-1] - r.t[0]), "s", "From first to last pose.")
    add("samples", "samples", len(r.t), "", "Poses over time of each robot.")
    add("step", "time step", r.step, "s", "Median time between samples.")
    add(
        "gaps",
        "gaps",
        len(gaps),
        "",
        "Places where more than three steps are missing; no estimate looks across one.",
    )
    add("gap_time", "time in gaps", lost, "s", "Seconds inside gaps.")


def _alignment(s: Situation, add: _Add) -> None:
    r, values = s.recording, s.curves.values
    since = _since(s)
    for short, words in (
        ("motion", "motion (Savitzky-Golay)"),
        ("headings", "headings"),
        ("differences", "raw differences"),
    ):
        gamma = _mean(values[f"gamma_{short}"][s.settled], _weights(r)[s.settled])
        left_out = _mean(values[f"left_out_{short}"][s.settled], _weights(r)[s.settled])
        add(
            f"gamma_{short}",
            f"γ from {words}",
            gamma if left_out <= 1.0 - FEWEST_COUNTED else float("nan"),
            "",
            f"Mean over time {since}, where defined; undefined when less than "
            f"{FEWEST_COUNTED:.1%} of robots and time can be counted.",
        )
        add(
            f"left_out_{short}",
            f"left out of γ from {words}",
            left_out,
            "share",
            f"Mean share of robots that γ does not count {since}.",
        )
    for short in ("motion", "headings"):
        aligned = ties.reached(np.nan_to_num(values[f"gamma_{short}"], nan=-2.0), s.threshold)
        reached = np.flatnonzero(aligned)
        add(
            f"time_to_alignment_{short}",
            f"time to γ ≥ {s.threshold:g} from {short}",
            float(r.t[reached[0]] - r.t[0]) if reached.size else float("nan"),
            "s",
            "From the first pose to the first sample at or above the threshold; "
            "undefined when it is never reached.",
        )
        # NaN where the last sample itself is below: alignment that ended is not for good.
        below = np.flatnonzero(~aligned)
        lasting = int(below[-1]) + 1 if below.size else 0
        add(
            f"time_aligned_for_good_{short}",
            f"time from which γ ≥ {s.threshold:g} for good, from {short}",
            float(r.t[lasting] - r.t[0]) if lasting < len(r.t) else float("nan"),
            "s",
            "From the first pose to the last time γ rises to the threshold and stays there; "
            "undefined when the run ends below it.",
        )
        add(
            f"share_aligned_{short}",
            f"time with γ ≥ {s.threshold:g} from {short}",
            _mean(aligned.astype(float), _weights(r)),
            "share",
            "Share of the whole run; samples where γ is undefined count as not aligned.",
        )
        add(
            f"steadiness_{short}",
            f"time with γ ≥ {s.threshold:g} from {short}, settled",
            _mean(aligned[s.settled].astype(float), _weights(r)[s.settled]),
            "share",
            f"The same {since}.",
        )
    for short in ("motion", "headings"):
        add(
            f"polarisation_{short}",
            f"polarisation, {short}",
            _mean(values[f"polarisation_{short}"][s.settled], _weights(r)[s.settled]),
            "",
            f"Mean over time {since}, where defined.",
        )
    heading = values["heading"][s.settled]
    add(
        "heading_spread",
        "spread of the flock's heading",
        _circular_deviation(heading),
        "rad",
        f"Circular standard deviation over time of the mean heading {since}.",
    )


def _motion(s: Situation, add: _Add) -> None:
    r, values = s.recording, s.curves.values
    since, weights = _since(s), _weights(r)
    speeds = s.curves.speeds
    add(
        "speed",
        "mean speed",
        _mean(values["speed"][s.settled], weights[s.settled]),
        "m/s",
        f"Mean over robots and time {since}.",
    )
    add(
        "drift",
        "speed of the centroid",
        _mean(values["drift"][s.settled], weights[s.settled]),
        "m/s",
        f"Mean over time {since}.",
    )
    stands = ties.within(speeds, s.slowest)
    standing = stands.mean(axis=1)
    add(
        "standing",
        "standing robots",
        _mean(standing[s.settled], weights[s.settled]),
        "share",
        f"Share of robots and time {since} at no more than {s.slowest:g} m/s.",
    )
    stood = np.array([_mean(row, weights[s.settled]) for row in stands[s.settled].T])
    add(
        "robots_standing",
        "robots that stood",
        float(ties.beyond(stood, 0.5).sum()),
        "",
        f"Robots that moved at no more than {s.slowest:g} m/s for over half the time {since}.",
    )
    final = ties.reached(r.t, r.t[-1] - LAST_SHARE * (r.t[-1] - r.t[0]))
    add(
        "standing_end",
        "standing robots at the end",
        _mean(standing[final], weights[final]),
        "share",
        "The same over the last tenth of the run.",
    )
    centroid = r.poses[:, :2].mean(axis=2)
    add(
        "centroid_displacement",
        "displacement of the centroid",
        float(np.hypot(*(centroid[-1] - centroid[0]))),
        "m",
        "Straight line from the first to the last position of the flock's centroid.",
    )
    if r.commands is not None:
        count, seconds = _stalls(r, speeds, s.slowest)
        add(
            "stalls",
            "stalls",
            count,
            "",
            f"Times a robot stood for over {STALL_SECONDS:g} s though commanded to drive at "
            f"{STALL_COMMAND:g} m/s or more.",
        )
        add("stall_time", "time stalled", seconds, "s", "Sum over robots.")
        add(
            "fastest_wheel",
            "fastest wheel asked for",
            float(values["fastest_wheel"].max()),
            "rad/s",
            f"Whole run; axle {s.robot.base_length:g} m.",
        )
        excess = values["fastest_wheel"] - s.robot.max_wheel_velocity
        excess[~ties.beyond(excess, 0.0)] = 0.0
        add(
            "wheel_excess",
            "largest excess over the wheel limit",
            float(excess.max()),
            "rad/s",
            f"How far a command asks for more than {s.robot.max_wheel_velocity:g} rad/s; "
            f"axle {s.robot.base_length:g} m.",
        )
        add(
            "wheel_excess_steps",
            "steps over the wheel limit",
            int((excess > 0).sum()),
            "",
            "Samples with at least one wheel asked for too much.",
        )


def _cohesion(s: Situation, add: _Add) -> None:
    values, since = s.curves.values, _since(s)
    weights = _weights(s.recording)
    radius = values["cohesive_radius"][s.settled]
    add(
        "cohesive_radius",
        "cohesive radius",
        _mean(radius, weights[s.settled]),
        "m",
        f"Mean {since}.",
    )
    ratio = float(radius.max() / radius.min()) if radius.min() > 0 else float("nan")
    add(
        "cohesive_radius_ratio",
        "cohesive radius, largest over smallest",
        ratio,
        "",
        f"Over time {since}.",
    )
    add(
        "spread",
        "spread",
        _mean(values["spread"][s.settled], weights[s.settled]),
        "m",
        f"Mean {since}.",
    )
    if s.recording.robots > 1:
        components = values["components"]
        add("components", "most groups at once", float(components.max()), "", "Whole run.")
        add(
            "connected",
            "time in one group",
            _mean((components == 1).astype(float), weights),
            "share",
            "Share of the whole run in which every robot is connected to every other.",
        )
        add(
            "algebraic_connectivity",
            "smallest algebraic connectivity",
            float(values["algebraic_connectivity"].min()),
            "",
            "Whole run.",
        )


def _safety(s: Situation, add: _Add) -> None:
    values, violations = s.curves.values, s.curves.violations
    kinds = [event.kind for event in violations.events]
    if s.recording.robots > 1:
        add(
            "nearest_neighbour",
            "nearest neighbour",
            _mean(values["nearest_neighbour"][s.settled], _weights(s.recording)[s.settled]),
            "m",
            f"Mean over robots and time {_since(s)}.",
        )
        add(
            "smallest_distance",
            "smallest distance of two robots",
            float(values["smallest_distance"].min()),
            "m",
            "Centre to centre, whole run.",
        )
        add(
            "smallest_collision_distance",
            "smallest distance of collision points",
            float(values["smallest_collision_distance"].min()),
            "m",
            f"Points {s.robot.collision_offset:g} m ahead of the centres, whole run; the "
            f"testbed calls less than {s.robot.collision_diameter:g} m a collision.",
        )
        add(
            "collisions",
            "collisions",
            kinds.count("collision"),
            "",
            "Times a pair came too close by the testbed's own test, each counted once.",
        )
        add(
            "collision_steps",
            "pairs too close, summed over steps",
            violations.close_pairs,
            "",
            "As the testbed counts.",
        )
    add(
        "smallest_wall_distance",
        "smallest distance to a wall",
        float(values["wall_distance"].min()),
        "m",
        "Of a robot's centre, whole run; negative outside.",
    )
    add(
        "boundary_events",
        "boundary crossings",
        kinds.count("boundary"),
        "",
        "Times a robot's centre left the arena.",
    )
    add("boundary_steps", "steps with a robot outside", violations.outside_steps, "", "Samples.")


def _certificate(s: Situation, add: _Add) -> None:
    r = s.recording
    if r.intervention is not None and np.isfinite(r.intervention).any():
        moved = r.intervention[np.isfinite(r.intervention)]
        intervened = ties.beyond(moved, INTERVENED)
        add(
            "interventions",
            "steps in which the certificate intervened",
            float(intervened.mean()),
            "share",
            f"Steps in which it changed a velocity by more than {1e3 * INTERVENED:g} mm/s.",
        )
        add(
            "intervention_mean",
            "mean intervention",
            float(moved[intervened].mean()) if intervened.any() else 0.0,
            "m/s",
            "Mean over those steps of the largest change of a robot's velocity.",
        )
        add("intervention_largest", "largest intervention", float(moved.max()), "m/s", "Whole run.")
    if "clearance" in s.curves.values:
        add(
            "clearance",
            "smallest clearance",
            float(np.nanmin(s.curves.values["clearance"])),
            "m",
            "Distance beyond what the certificate keeps between look-ahead points and from walls, "
            "whole run; negative where it was not kept.",
        )
        first = float(s.curves.values["clearance"][0])
        if np.isfinite(first):
            add(
                "clearance_first",
                "clearance at the start",
                first,
                "m",
                "Negative: the run started unsafe, so that the certificate guarantees nothing.",
            )
    if r.status is not None:
        unsolved = int(np.isin(r.status, ("relaxed", "failed")).sum())
        add(
            "unsolved",
            "steps without an exact solution",
            unsolved,
            "",
            "Steps in which the certificate was relaxed or failed.",
        )


def _confidence(s: Situation, add: _Add) -> None:
    moving = s.curves.speeds[s.settled]
    moving = moving[np.isfinite(moving) & (moving > s.slowest)]
    speed = float(np.median(moving)) if moving.size else 0.0
    noise = tracking_noise(s.recording, speed, s.window)
    add(
        "noise_position",
        "tracking noise, position",
        noise.position,
        "m",
        "Standard deviation of each coordinate around local quadratics, measured in this log.",
    )
    add("noise_heading", "tracking noise, heading", noise.heading, "rad", "The same for headings.")
    add(
        "noise_course",
        "error of the direction of motion",
        noise.course,
        "rad",
        "Standard deviation that this noise gives the Savitzky-Golay direction of a robot at "
        "the median speed of those that move.",
    )
    add(
        "gamma_bias",
        "γ from motion is under-read by about",
        expected_bias(noise.course),
        "",
        "1 - exp(-σ²) with that error σ: what perfectly parallel robots would lose.",
    )
    add(
        "heading_offset",
        "heading against direction of motion",
        _heading_offset(s),
        "rad",
        "Median over robots and time of the angle between heading and line of motion; "
        "large when the headings are not in radians or belong to other robots.",
    )


def _since(s: Situation) -> str:
    if s.settled.all():
        return "of the whole run"
    first = int(np.argmax(s.settled))
    return f"after {s.recording.t[first] - s.recording.t[0]:.0f} s"


def _weights(r: Run) -> Floats:
    """Return the time each sample stands for; all one when samples are evenly spaced."""
    steps = np.diff(r.t)
    if np.abs(steps - steps.mean()).max() <= 1e-6 * steps.mean():
        return np.ones(len(r.t))
    steps[r.gaps - 1] = r.step
    return np.append(steps, r.step)


def _mean(values: Floats, weights: Floats) -> float:
    known = np.isfinite(values)
    if not known.any():
        return float("nan")
    if (weights == 1.0).all():
        return float(values[known].mean())
    return float(np.average(values[known], weights=weights[known]))


def _circular_deviation(angles: Floats) -> float:
    known = angles[np.isfinite(angles)]
    if not known.size:
        return float("nan")
    length = min(1.0, float(np.abs(np.exp(1j * known).mean())))
    return float(np.sqrt(-2.0 * np.log(length))) if length > 0 else float("inf")


def _stalls(r: Run, speeds: Floats, slowest: float) -> tuple[int, float]:
    """Count stalls and their seconds, robot by robot."""
    assert r.commands is not None
    driven = ties.reached(np.abs(r.commands[:, 0]), STALL_COMMAND)
    stuck = ties.within(speeds, slowest) & driven
    count, seconds = 0, 0.0
    for column in stuck.T:
        edges = np.diff(np.concatenate([[0], column.astype(np.int8), [0]]))
        for first, last in zip(
            np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1, strict=True
        ):
            length = float(r.t[last] - r.t[first])
            if ties.beyond(length, STALL_SECONDS):
                count += 1
                seconds += length
    return count, seconds


def _heading_offset(s: Situation) -> float:
    """Return the median angle between the heading and the line along which a robot moves."""
    r = s.recording
    stride = max(1, len(r.t) // 5000)
    ahead = min(10, len(r.t) - 1)
    start = np.arange(0, len(r.t) - ahead, stride)
    step = r.poses[start + ahead, :2] - r.poses[start, :2]
    within = (r.t[start + ahead] - r.t[start]) < 3 * ahead * r.step
    length = np.hypot(step[:, 0], step[:, 1])
    moving = (length > max(s.slowest * ahead * r.step, 0.005)) & within[:, np.newaxis]
    if not moving.any():
        return float("nan")
    middle = r.poses[start + ahead // 2, 2]
    across = -np.sin(middle) * step[:, 0] + np.cos(middle) * step[:, 1]
    along = np.cos(middle) * step[:, 0] + np.sin(middle) * step[:, 1]
    return float(np.median(np.arctan2(np.abs(across), np.abs(along))[moving]))


_GROUPS: dict[str, Callable[[Situation, _Add], None]] = {
    "Run": _run,
    "Alignment": _alignment,
    "Motion": _motion,
    "Cohesion": _cohesion,
    "Safety": _safety,
    "Certificate": _certificate,
    "Confidence": _confidence,
}
