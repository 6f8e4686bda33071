"""The run in sentences: did it align, stay together and stay safe, and how sure are we?

A verdict is judged by motion and never by headings alone: a flock that has parked at a wall has
parallel headings, a γ from headings near one, and does not flock.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from posflock_robotarium.report.numbers import Number
from posflock_robotarium.report.readers import Recording

Mark = Literal["good", "caution", "bad", "unknown"]

MOSTLY = 0.5
"""A flock of which more than this share stands, stands."""

SOME = 0.1
"""A share too large to pass over in silence."""

WRONG_HEADINGS = 0.35
"""Radians (20°) between headings and motion that no tracking offset explains."""


@dataclass(frozen=True)
class Verdict:
    """One sentence about the run.

    Attributes
    ----------
    question : str
        What it answers.
    mark : {'good', 'caution', 'bad', 'unknown'}
        How the run does.
    answer : str
        A few words.
    because : str
        The figures it rests on.
    """

    question: str
    mark: Mark
    answer: str
    because: str


def verdicts_of(
    recording: Recording, numbers: Mapping[str, Number], threshold: float, slowest: float
) -> tuple[Verdict, ...]:
    """Judge a run by its numbers.

    Parameters
    ----------
    recording : Recording
        For what the log says about how the run ended.
    numbers : mapping of Number
        From `numbers.numbers_of`.
    threshold : float
        γ from which the flock counts as aligned.
    slowest : float
        Speed in m/s up to which a robot stands.

    Returns
    -------
    tuple of Verdict
        Aligned? Together? Safe? Within limits? How sure? Complete?
    """
    value = {key: float(number.value) for key, number in numbers.items()}
    verdicts = [_aligned(value, threshold, slowest), _together(value), _safe(value)]
    verdicts += _limits(value)
    verdicts.append(_sure(value))
    verdicts += _complete(recording, value)
    return tuple(verdicts)


def _aligned(v: Mapping[str, float], threshold: float, slowest: float) -> Verdict:
    question = "Did the flock align?"
    if v["robots"] < 2:
        return Verdict(question, "unknown", "One robot has nobody to align with.", "")
    motion, headings = v["gamma_motion"], v["gamma_headings"]
    standing, at_end = v["standing"], v["standing_end"]
    both = f"γ from motion {_g(motion)}, from headings {_g(headings)}, means after the start"
    if v["left_out_headings"] >= 1.0:
        return Verdict(
            question, "unknown", "No robot had a neighbour.", "γ is undefined without neighbours."
        )
    if standing > MOSTLY or at_end > MOSTLY:
        parallel = headings >= threshold
        pointing = (
            f"Their headings are parallel (γ from headings {_g(headings)}), as those of parked "
            "robots may be; this is not flocking."
            if parallel
            else f"γ from headings is {_g(headings)}."
        )
        moving = (
            "γ from motion is undefined, since nobody moves."
            if math.isnan(motion)
            else f"γ from motion is {_g(motion)}, over the few that move."
            if standing > MOSTLY
            else f"While it moved, γ from motion was {_g(motion)}."
        )
        answer = (
            "No: nothing moves." if standing > 0.95 else
            "No: the flock stands most of the time." if standing > MOSTLY else
            "It came to a stop."
        )  # fmt: skip
        return Verdict(
            question,
            "bad",
            answer,
            f"Robots are slower than {slowest:g} m/s for {_pc(standing)} of the time, and "
            f"{_pc(at_end)} of them at the end. {pointing} {moving}",
        )
    reached = v["time_to_alignment_motion"]
    held = (
        f"γ from motion first reached {threshold:g} after {reached:.1f} s and was there for "
        f"{_pc(v['share_aligned_motion'])} of the run."
        if not math.isnan(reached)
        else f"γ from motion never reached {threshold:g}."
    )
    left_out = (
        f" γ from motion leaves out {_pc(v['left_out_motion'])} of the robots as too slow to have "
        "a direction or without a neighbour."
        if v["left_out_motion"] > 0.005
        else ""
    )
    because = f"{both}. {held}{left_out}"
    if motion >= threshold and headings >= threshold:
        if standing > SOME or v["left_out_motion"] > 0.25:
            return Verdict(question, "caution", "Those that moved did.", because)
        if v["share_aligned_motion"] < 0.75:
            return Verdict(question, "caution", "On average, not steadily.", because)
        return Verdict(question, "good", "Yes.", because)
    if headings >= threshold:
        return Verdict(
            question, "bad", "Headings did, motion did not: the flock does not move as one.", because
        )  # fmt: skip
    if motion >= threshold:
        return Verdict(
            question,
            "caution",
            "Motion did, headings did not: some drive backwards, or headings are wrong.",
            because,
        )
    return Verdict(question, "bad", "No.", because)


def _together(v: Mapping[str, float]) -> Verdict:
    question = "Did it stay together?"
    if v["robots"] < 2:
        return Verdict(question, "unknown", "One robot.", "")
    ratio = v["cohesive_radius_ratio"]
    grew = "" if math.isnan(ratio) else f", varying by a factor of {ratio:.2f}"
    radius = f"The cohesive radius is {v['cohesive_radius']:.2f} m{grew}."
    if v["components"] <= 1:
        least = v["algebraic_connectivity"]
        return Verdict(
            question, "good", "Yes, one group throughout.",
            f"Algebraic connectivity never below {least:.2g}. {radius}",
        )  # fmt: skip
    share, groups = v["connected"], int(v["components"])
    mark: Mark = "caution" if share >= 0.9 else "bad"
    answer = "Nearly always." if share >= 0.9 else "No." if share < MOSTLY else "Not always."
    return Verdict(
        question, mark, answer,
        f"One group for {_pc(share)} of the time, up to {groups} groups. {radius}",
    )  # fmt: skip


def _safe(v: Mapping[str, float]) -> Verdict:
    question = "Was it safe?"
    crossings = int(v["boundary_events"])
    collisions = int(v.get("collisions", 0))
    wall = f"the wall was never nearer than {v['smallest_wall_distance']:.3f} m"
    if crossings:
        wall = f"a centre was {-v['smallest_wall_distance']:.3f} m outside the arena"
    pairs = (
        f"Centres never closer than {v['smallest_distance']:.3f} m, collision points "
        f"{v['smallest_collision_distance']:.3f} m; "
        if "smallest_distance" in v
        else ""
    )
    because = f"{pairs}{wall}." if pairs else f"{wall[0].upper()}{wall[1:]}."
    if not collisions and not crossings:
        return Verdict(question, "good", "Yes: no collision, nobody outside.", because)
    what = [f"{n} {word}{'s' if n > 1 else ''}"
            for n, word in ((collisions, "collision"), (crossings, "boundary crossing")) if n]  # fmt: skip
    return Verdict(question, "bad", f"No: {' and '.join(what)}.", because)


def _limits(v: Mapping[str, float]) -> Iterator[Verdict]:
    question = "Within the robots' limits?"
    if "wheel_excess" not in v:
        yield Verdict(
            question, "unknown", "Unknown: no commands in the log.",
            "Wheel limits, stalls and interventions cannot be judged from poses.",
        )  # fmt: skip
        return
    faults = []
    if v["wheel_excess"] > 0:
        faults.append(
            f"{int(v['wheel_excess_steps'])} steps ask a wheel for up to "
            f"{v['wheel_excess']:.2f} rad/s too much"
        )
    if v["stalls"]:
        faults.append(f"{int(v['stalls'])} stalls, {v['stall_time']:.1f} s in all")
    if v.get("unsolved"):
        faults.append(f"{int(v['unsolved'])} steps whose certificate had no exact solution")
    helped = (
        f"The certificate intervened in {_pc(v['interventions'])} of the steps, by up to "
        f"{v['intervention_largest']:.3f} m/s."
        if "interventions" in v
        else ""
    )
    if faults:
        text = "; ".join(faults)
        yield Verdict(question, "bad" if v["wheel_excess"] > 0 else "caution", "Not throughout.",
                      f"{text[0].upper()}{text[1:]}. {helped}".strip())  # fmt: skip
    else:
        yield Verdict(question, "good", "Yes.", f"No wheel over its limit, no stall. {helped}")


def _sure(v: Mapping[str, float]) -> Verdict:
    question = "How sure are we?"
    if v["heading_offset"] > WRONG_HEADINGS:
        return Verdict(
            question,
            "bad",
            "Not at all: headings and motion disagree.",
            f"Robots move at {math.degrees(v['heading_offset']):.0f}° to their headings, which "
            "wheels cannot do: are headings in radians, and columns in the right order?",
        )
    noise, course, bias = v["noise_position"], v["noise_course"], v["gamma_bias"]
    gaps = f" {int(v['gaps'])} gap(s), {v['gap_time']:.1f} s, are left as gaps." if v["gaps"] else ""
    if math.isnan(noise):
        return Verdict(question, "unknown", "Too short to measure the noise.", gaps.strip())
    tracked = f"Tracking noise, measured in this log, is {_length(noise)}"
    if math.isnan(course):
        return Verdict(question, "caution", "Directions of motion are undefined.",
                       f"{tracked}; nothing moves.{gaps}")  # fmt: skip
    because = (
        f"{tracked}, so a direction of motion is sure to {math.degrees(course):.2g}° and γ from "
        f"motion is under-read by about {bias:.1g}; raw differences read "
        f"{_g(v['gamma_differences'])}.{gaps}"
    )
    if bias > 0.02:
        return Verdict(question, "caution", "γ from motion is noisy.", because)
    return Verdict(question, "good", "The estimate is sharp.", because)


def _complete(recording: Recording, v: Mapping[str, float]) -> Iterator[Verdict]:
    question = "Is it the whole run?"
    parameters = recording.parameters
    ended = parameters.get("ended")
    how = ended.get("how") if isinstance(ended, dict) else None
    planned = parameters.get("duration")
    length = f"{v['duration']:.1f} s are logged"
    known = isinstance(planned, (int, float)) and math.isfinite(planned)
    if known:
        length += f" of {planned:.1f} s planned"
    if how == "finished":
        yield Verdict(question, "good", "Yes, the run finished.", f"{length}.")
    elif how is not None:
        reason = ended.get("reason") if isinstance(ended, dict) else ""
        words = "it was killed, or still goes on" if how == "running" else f"{how}"
        yield Verdict(
            question, "caution", f"No: {words}.", f"{length}. {reason or ''}".strip()
        )
    elif known and v["duration"] < 0.95 * float(planned or 0.0):
        yield Verdict(question, "caution", "Shorter than planned.", f"{length}.")


def _g(gamma: float) -> str:
    if math.isnan(gamma):
        return "undefined"
    # 0.9996 must not read as a perfect 1.000.
    return f"{gamma:.3f}" if gamma < 0.9995 else f"{gamma:.5f}"


def _pc(share: float) -> str:
    percent = 100.0 * share
    if 0 < percent < 1 or 99 < percent < 100:
        return f"{percent:.1f} %" if 0.05 <= percent < 99.95 else (
            "under 0.1 %" if percent < 1 else "over 99.9 %"
        )  # fmt: skip
    return f"{percent:.0f} %"


def _length(metres: float) -> str:
    return f"{1000 * metres:.2f} mm" if metres >= 5e-6 else "below 0.01 mm"
