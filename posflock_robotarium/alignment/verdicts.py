"""The run in sentences: whether it aligned, stayed together and safe, and how sure that is.

A verdict is judged by motion and never by headings alone: a flock that has parked at a wall has
parallel headings, a γ from headings near one, and does not flock.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from barrier_certificates import ties
from posflock_robotarium.alignment.following_verdict import following_verdict
from posflock_robotarium.alignment.loop_verdict import loop_verdict
from posflock_robotarium.alignment.metric_registry import Number
from posflock_robotarium.alignment.metrics import SMOOTHING_POINTS
from posflock_robotarium.alignment.questions import Questions
from posflock_robotarium.alignment.run_verdict import Mark, RunVerdict
from posflock_robotarium.alignment.shape_verdicts import covered, kept_formation
from posflock_robotarium.alignment.target_outcomes import TargetOutcome, verdict_of
from posflock_robotarium.alignment.whole_run import whole_run_verdict
from posflock_robotarium.logs import plausibility
from posflock_robotarium.logs.run import Run

MOSTLY = 0.5
"""A flock of which more than this share stands, stands."""

FEWEST_SAMPLES = SMOOTHING_POINTS
"""Poses over time without which a direction of motion is mostly noise."""

SOME = 0.1
"""A share too large to pass over in silence."""

WRONG_HEADINGS = 0.35
"""Radians (20°) between headings and motion that no tracking offset explains."""

NOISY = 0.005
"""Metres of tracking noise, ten times that of the testbed, which positions are noisy with."""

DOUBTFUL_HEADINGS = 0.15
"""The same (9°) where headings begin at values that are no angles in radians."""

__all__ = ["Mark", "RunVerdict", "headline", "verdicts_of"]

SURE = "How sure are we?"


def verdicts_of(
    recording: Run,
    numbers: Mapping[str, Number],
    threshold: float,
    slowest: float,
    questions: Questions = Questions.FLOCKING,
    targets: Sequence[TargetOutcome] = (),
) -> tuple[RunVerdict, ...]:
    """Judge a run by its numbers.

    Parameters
    ----------
    recording : Run
        For what the log says about how the run ended.
    numbers : mapping of Number
        From `measuring.numbers_of`.
    threshold : float
        γ from which the flock counts as aligned.
    slowest : float
        Speed in m/s up to which a robot stands.
    questions : Questions
        What the run is asked.
    targets : sequence of TargetOutcome
        How it did by its targets.

    Returns
    -------
    tuple of RunVerdict
        Aligned and together, or in formation, or covering, as asked; on target? Then of any run:
        safe? Within limits? How sure? As told? In time? The whole run?
    """
    value = {key: float(number.value) for key, number in numbers.items()}
    verdicts = [verdict_of(target) for target in targets]
    flocking = questions is Questions.FLOCKING
    if flocking:
        verdicts += [_aligned(value, threshold, slowest, recording.headed), _together(value)]
    elif questions is Questions.FORMATION:
        verdicts.append(kept_formation(value))
    elif questions is Questions.COVERAGE:
        verdicts.append(covered(value))
    stopped = recording.printed is not None and recording.printed.collision
    verdicts.append(_safe(value, stopped=stopped))
    verdicts += _limits(value)
    sure = _in_degrees(recording, value) or _jumping(recording) or _sure(value, flocking)
    verdicts.append(sure)
    verdicts += following_verdict(value)
    verdicts += loop_verdict(recording, value)
    verdicts += whole_run_verdict(recording, value)
    return tuple(verdicts)


def headline(verdicts: tuple[RunVerdict, ...]) -> str:
    """Return the run in a few words: ``aligned, together, safe``.

    Parameters
    ----------
    verdicts : tuple of RunVerdict
        The run in sentences.
    """
    return ", ".join(verdict.short for verdict in verdicts if verdict.short)


def _aligned(v: Mapping[str, float], threshold: float, slowest: float, headed: bool) -> RunVerdict:
    question = "Did the flock align?"
    motion, headings = v["gamma_motion"], v["gamma_headings"]
    if v["robots"] < 2:
        return RunVerdict(
            question, Mark.UNKNOWN, "One robot has nobody to align with.", "", "alone"
        )
    if v["left_out_headings" if headed else "left_out_motion"] >= 1.0:
        because = "γ is undefined without neighbours."
        return RunVerdict(
            question, Mark.UNKNOWN, "No robot had a neighbour.", because, "no neighbours"
        )
    if v["samples"] < FEWEST_SAMPLES:
        because = f"{int(v['samples'])} poses over time do not tell motion from tracking noise."
        return RunVerdict(question, Mark.UNKNOWN, "Too short to tell.", because, "too short")
    if ties.beyond(v["standing"], MOSTLY) or ties.beyond(v["standing_end"], MOSTLY):
        return _parked(v, threshold, slowest)
    because = f"{_both(motion, headings)}. {_when(v, threshold)}"
    if v["left_out_motion"] > 0.005:
        because += (
            f" γ from motion leaves out {_pc(v['left_out_motion'])} of the robots as too slow to "
            "have a direction, or without a neighbour that moves."
        )
    moves_aligned = ties.reached(motion, threshold)
    points_aligned = ties.reached(headings, threshold) if headed else moves_aligned
    if moves_aligned and points_aligned:
        if stood := int(v["robots_standing"]):
            because += f" {stood} of {v['robots']:g} robots stood over half the time."
        many_stand = stood or ties.beyond(v["standing"], SOME)
        if many_stand or ties.beyond(v["left_out_motion"], 0.25):
            return RunVerdict(
                question, Mark.CAUTION, "Those that moved did.", because, "partly aligned"
            )
        if ties.short_of(v["steadiness_motion"], 0.75):
            answer = "On average, not steadily."
            return RunVerdict(question, Mark.CAUTION, answer, because, "unsteadily aligned")
        return RunVerdict(question, Mark.GOOD, "Yes.", because, "aligned")
    if points_aligned:
        answer = "No: headings are parallel, motion is not."
        return RunVerdict(question, Mark.BAD, answer, because, "not aligned in motion")
    if moves_aligned:
        answer = "Motion did, headings did not: some drive backwards, or headings are wrong."
        return RunVerdict(question, Mark.CAUTION, answer, because, "aligned in motion only")
    return RunVerdict(question, Mark.BAD, "No.", because, "not aligned")


def _parked(v: Mapping[str, float], threshold: float, slowest: float) -> RunVerdict:
    """Say that the flock stands, whatever its headings do."""
    motion, headings, standing = v["gamma_motion"], v["gamma_headings"], v["standing"]
    if ties.beyond(standing, 0.95):
        answer, short = "No: nothing moves.", "parked"
    elif ties.beyond(standing, MOSTLY):
        answer, short = "No: the flock stands most of the time.", "mostly parked"
    else:
        answer, short = "No: it came to a stop.", "came to a stop"
    because = (
        f"Robots are slower than {slowest:g} m/s for {_pc(standing)} of the time, and "
        f"{_pc(v['standing_end'])} of them over the last tenth of the run. "
    )
    because += (
        f"Headings are parallel (γ from headings {_g(headings)}), as those of parked robots may "
        "be; that is not flocking. "
        if ties.reached(headings, threshold)
        else f"γ from headings is {_g(headings)}. "
    )
    because += (
        "γ from motion is undefined, since nobody moves."
        if math.isnan(motion)
        else f"γ from motion is {_g(motion)}, over the robots that move."
    )
    return RunVerdict("Did the flock align?", Mark.BAD, answer, because, short)


def _both(motion: float, headings: float) -> str:
    return f"γ from motion {_g(motion)}, from headings {_g(headings)} once settled"


def _when(v: Mapping[str, float], threshold: float) -> str:
    if math.isnan(v["time_to_alignment_motion"]):
        return f"γ from motion never reached {threshold:g}."
    for_good = v["time_aligned_for_good_motion"]
    lasting = "" if math.isnan(for_good) else f", and from {for_good:.1f} s on for good"
    return (
        f"γ from motion was {threshold:g} or more for {_pc(v['share_aligned_motion'])} of the "
        f"run{lasting}."
    )


def _together(v: Mapping[str, float]) -> RunVerdict:
    question = "Did it stay together?"
    if v["robots"] < 2:
        return RunVerdict(question, Mark.UNKNOWN, "One robot.", "")
    ratio = v["cohesive_radius_ratio"]
    varying = "" if math.isnan(ratio) else f", varying by a factor of {ratio:.2f}"
    radius = f"The cohesive radius is {v['cohesive_radius']:.2f} m{varying}."
    if v["components"] <= 1:
        because = f"Algebraic connectivity never below {v['algebraic_connectivity']:.2g}. {radius}"
        return RunVerdict(question, Mark.GOOD, "Yes, one group throughout.", because, "together")
    share = v["connected"]
    because = (
        f"One group for {_pc(share)} of the time, up to {int(v['components'])} groups. {radius}"
    )
    if ties.reached(share, 0.9):
        return RunVerdict(question, Mark.CAUTION, "Nearly always.", because, "mostly together")
    answer = "No." if ties.short_of(share, MOSTLY) else "Not always."
    return RunVerdict(question, Mark.BAD, answer, because, "split")


def _safe(v: Mapping[str, float], stopped: bool) -> RunVerdict:
    question = "Was it safe?"
    counts = (
        (int(v.get("collisions", 0)), "collision"),
        (int(v["boundary_events"]), "boundary crossing"),
    )
    nearest = v["smallest_wall_distance"]
    because = (
        f"Centres came no nearer to a wall than {max(nearest, 0.0):.3f} m."
        if ties.reached(nearest, 0.0)
        else f"A centre was {-nearest:.3f} m outside the arena."
    )
    unseen = "smallest_distance" in v and "collisions" not in v
    if unseen:
        because = f"Centres never closer than {v['smallest_distance']:.3f} m. {because}"
    elif "smallest_distance" in v:
        because = (
            f"Centres never closer than {v['smallest_distance']:.3f} m, collision points "
            f"{v['smallest_collision_distance']:.3f} m. {because}"
        )
    if ties.short_of(v.get("clearance_first", 0.0), 0.0):
        because += (
            f" It started {1e3 * -v['clearance_first']:.0f} mm closer than the certificate keeps: "
            "until that was made good, it guaranteed nothing."
        )
    faults = " and ".join(f"{n} {word}{'s' if n > 1 else ''}" for n, word in counts if n)
    if faults:
        return RunVerdict(question, Mark.BAD, f"No: {faults}.", because, f"unsafe: {faults}")
    if stopped:
        answer = "No: the testbed detected a collision."
        return RunVerdict(question, Mark.BAD, answer, because, "unsafe: 1 collision")
    if unseen:
        answer = "Nobody outside; collisions are unknown without headings."
        return RunVerdict(question, Mark.UNKNOWN, answer, because)
    return RunVerdict(question, Mark.GOOD, "Yes: no collision, nobody outside.", because, "safe")


def _limits(v: Mapping[str, float]) -> Iterator[RunVerdict]:
    question = "Within the robots' limits?"
    if "wheel_excess" not in v:
        yield RunVerdict(
            question,
            Mark.UNKNOWN,
            "Unknown: no commands in the log.",
            "Wheel limits, stalls and interventions cannot be judged from poses.",
        )
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
        yield RunVerdict(
            question,
            Mark.BAD if v["wheel_excess"] > 0 else Mark.CAUTION,
            "Not throughout.",
            f"{text[0].upper()}{text[1:]}. {helped}".strip(),
        )
    else:
        yield RunVerdict(
            question, Mark.GOOD, "Yes.", f"No wheel over its limit, no stall. {helped}"
        )


def _in_degrees(recording: Run, v: Mapping[str, float]) -> RunVerdict | None:
    """Judge headings that begin beyond a full turn, and that motion does not confirm."""
    first = float(np.nanmax(np.abs(recording.poses[0, 2]))) if recording.headed else 0.0
    if first <= 2 * math.pi or not v["heading_offset"] > DOUBTFUL_HEADINGS:
        return None
    return RunVerdict(
        SURE,
        Mark.BAD,
        "Not at all: headings seem to be in degrees.",
        f"They begin at up to {first:.3g}, which is no angle in radians, and robots do not move "
        "along them: report again with --degrees.",
    )


def _jumping(recording: Run) -> RunVerdict | None:
    """Judge poses that no wheels can reach."""
    told = plausibility.told(recording) if recording.headed else None
    return None if told is None else RunVerdict(SURE, Mark.BAD, *told)


def _sure(v: Mapping[str, float], flocking: bool) -> RunVerdict:
    question = SURE
    if v["heading_offset"] > WRONG_HEADINGS:
        return RunVerdict(
            question,
            Mark.BAD,
            "Not at all: headings and motion disagree.",
            f"Robots move at {math.degrees(v['heading_offset']):.0f}° to their headings, which "
            "wheels cannot do: are headings in radians, and columns in the right order?",
        )
    noise, course = v["noise_position"], v["noise_course"]
    count = int(v["gaps"])
    gaps = (
        f" {count} gap{'s' if count > 1 else ''}, {v['gap_time']:.1f} s, left as such."
        if count
        else ""
    )
    if math.isnan(noise):
        return RunVerdict(question, Mark.UNKNOWN, "Too short to measure the noise.", gaps.strip())
    tracked = f"Tracking noise, measured in this log, is {_length(noise)}"
    if not flocking:
        sharp = ties.within(noise, NOISY)
        mark, word = (Mark.GOOD, "sharp") if sharp else (Mark.CAUTION, "noisy")
        return RunVerdict(question, mark, f"Positions are {word}.", f"{tracked}.{gaps}")
    bias = v["gamma_bias"]
    if math.isnan(course):
        return RunVerdict(
            question,
            Mark.CAUTION,
            "Directions of motion are undefined.",
            f"{tracked}; nothing moves.{gaps}",
        )
    because = (
        f"{tracked}, so a direction of motion is sure to {math.degrees(course):.2g}° and γ from "
        f"motion is under-read by {_bias(bias)}; raw differences read "
        f"{_g(v['gamma_differences'])}.{gaps}"
    )
    if ties.beyond(v["left_out_motion"], 0.25):
        answer = "γ from motion speaks for few robots."
        return RunVerdict(
            question, Mark.CAUTION, answer, f"It leaves out {_pc(v['left_out_motion'])}. {because}"
        )
    if bias > 0.02:
        return RunVerdict(question, Mark.CAUTION, "γ from motion is noisy.", because)
    return RunVerdict(question, Mark.GOOD, "The estimate is sharp.", because)


def _g(gamma: float) -> str:
    if math.isnan(gamma):
        return "undefined"
    # 0.9996 must not read as a perfect 1.000.
    return f"{gamma:.5f}" if 0.9995 <= gamma < 0.999995 else f"{gamma:.3f}"


def _pc(share: float) -> str:
    percent = 100.0 * share
    if 0 < percent < 1 or 99 < percent < 100:
        return (
            f"{percent:.1f} %"
            if 0.05 <= percent < 99.95
            else ("under 0.1 %" if percent < 1 else "over 99.9 %")
        )
    return f"{percent:.0f} %"


def _bias(bias: float) -> str:
    return f"about {bias:.1g}" if bias >= 1e-4 else "less than 0.0001"


def _length(metres: float) -> str:
    return f"{1000 * metres:.2f} mm" if metres >= 5e-6 else "below 0.01 mm"
