"""The run in sentences: whether it aligned, stayed together and safe, and how sure that is.

A verdict is judged by motion and never by headings alone: a flock that has parked at a wall has
parallel headings, a γ from headings near one, and does not flock.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from barrier_certificates import ties
from posflock_robotarium.alignment.certainty import certainty, unseen_safety
from posflock_robotarium.alignment.following_verdict import following_verdict
from posflock_robotarium.alignment.loop_verdict import loop_verdict
from posflock_robotarium.alignment.metric_registry import Number
from posflock_robotarium.alignment.metrics import SMOOTHING_POINTS
from posflock_robotarium.alignment.questions import Questions
from posflock_robotarium.alignment.run_verdict import Mark, RunVerdict
from posflock_robotarium.alignment.shape_verdicts import covered, kept_formation
from posflock_robotarium.alignment.target_outcomes import TargetOutcome, verdicts_of_targets
from posflock_robotarium.alignment.verdict_words import gamma_text as _g
from posflock_robotarium.alignment.verdict_words import share_text as _pc
from posflock_robotarium.alignment.verdict_words import since_text
from posflock_robotarium.alignment.whole_run import whole_run_verdict
from posflock_robotarium.logs.plausibility import Sightings, sightings_of
from posflock_robotarium.logs.run import Run
from posflock_robotarium.logs.told_sightings import Losses, losses_of

MOSTLY = 0.5
"""A flock of which more than this share stands, stands."""

FEWEST_SAMPLES = SMOOTHING_POINTS
"""Poses over time without which a direction of motion is mostly noise."""

SOME = 0.1
"""A share too large to pass over in silence."""

__all__ = ["Mark", "RunVerdict", "headline", "verdicts_of"]


def verdicts_of(
    recording: Run,
    numbers: Mapping[str, Number],
    threshold: float,
    slowest: float,
    questions: Questions = Questions.FLOCKING,
    targets: Sequence[TargetOutcome] = (),
    found: Sightings | None = None,
) -> tuple[RunVerdict, ...]:
    """Judge a run by its numbers.

    Parameters
    ----------
    recording : Run
        Poses as logged, and what the log says about how the run ended.
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
    found : Sightings, optional
        What is believed of the poses; looked for by default.

    Returns
    -------
    tuple of RunVerdict
        Aligned and together, or in formation, or covering, as asked; on target? Then of any run:
        safe? Within limits? How sure? As told? In time? The whole run?
    """
    value = {key: float(number.value) for key, number in numbers.items()}
    if found is None:
        found = sightings_of(recording, recording.t, counted=not recording.timed)
    losses = losses_of(recording, found)
    verdicts = verdicts_of_targets(targets, value.get("drive_in_log", 0.0))
    flocking = questions is Questions.FLOCKING
    if flocking:
        verdicts += [
            _aligned(value, threshold, slowest, recording.headed),
            _together(value, losses),
        ]
    elif questions is Questions.FORMATION:
        verdicts.append(kept_formation(value))
    elif questions is Questions.COVERAGE:
        verdicts.append(covered(value))
    stopped = recording.printed is not None and recording.printed.collision
    safe = _safe(value, stopped=stopped)
    verdicts.append(unseen_safety(safe, value, recording, losses))
    verdicts += _limits(value)
    verdicts.append(certainty(recording, value, found, losses, flocking))
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
    lasting = "" if math.isnan(for_good) else f", and for good {_since(v, for_good)}"
    return (
        f"γ from motion was {threshold:g} or more for {_pc(v['share_aligned_motion'])} of the "
        f"run{lasting}."
    )


def _since(v: Mapping[str, float], seconds: float) -> str:
    return since_text(seconds, v.get("drive_in_log", 0.0))


def _together(v: Mapping[str, float], losses: Losses) -> RunVerdict:
    question = "Did it stay together?"
    if v["robots"] < 2:
        return RunVerdict(question, Mark.UNKNOWN, "One robot.", "")
    if math.isnan(v["components"]):
        because = "Those who are seen have parted, but who is not seen may link them."
        return RunVerdict(question, Mark.UNKNOWN, "Unknown: too few robots are seen.", because)
    ratio = v["cohesive_radius_ratio"]
    varying = "" if math.isnan(ratio) else f", varying by a factor of {ratio:.2f}"
    radius = f"The cohesive radius is {v['cohesive_radius']:.2f} m{varying}."
    if losses.seen < 1.0:
        radius += " All of it is told of the robots that are seen."
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
