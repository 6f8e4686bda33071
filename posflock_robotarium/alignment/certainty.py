"""How sure an answer is: what headings, noise and the robots that are not seen leave of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from barrier_certificates import ties
from posflock_robotarium.alignment.band_words import band_sentence
from posflock_robotarium.alignment.run_verdict import Mark, RunVerdict
from posflock_robotarium.alignment.verdict_words import (
    angle_text,
    bias_text,
    gamma_text,
    length_text,
    share_text,
)
from posflock_robotarium.logs.plausibility import Sightings, of_robots
from posflock_robotarium.logs.run import Run
from posflock_robotarium.logs.teleports import fastest
from posflock_robotarium.logs.told_sightings import (
    Losses,
    perhaps_frozen,
    too_fast,
    what_is_lost,
    who_is_seen,
)

SURE = "How sure are we?"

WRONG_HEADINGS = 0.35
"""Radians (20°) between headings and motion that no tracking offset explains."""

DOUBTFUL_HEADINGS = 0.15
"""The same (9°) where headings begin at values that are no angles in radians."""

NOISY = 0.005
"""Metres of tracking noise, ten times that of the testbed, which positions are noisy with."""

SHORT_LOSS = 0.5
"""Seconds for which a robot may be unseen without a word of caution."""

HARMLESS = 0.2
"""Seconds in which nothing happens that is not to be seen after them, too."""

NEARLY_ALL, TOO_FEW = 0.98, 0.5
"""Shares of robots and times seen from which on little is lost, and up to which too much."""

SMALL_SHIFT = 0.02
"""By how much γ may be off before that is a caution."""


def certainty(
    recording: Run,
    v: Mapping[str, float],
    found: Sightings,
    losses: Losses,
    flocking: bool = True,
) -> RunVerdict:
    """Judge how sure the other answers are.

    Parameters
    ----------
    recording : Run
        Poses as logged.
    v : mapping of float
        Numbers by their keys.
    found : Sightings
        What is believed of the poses.
    losses : Losses
        What is lost of them.
    flocking : bool
        Whether the run is asked how it aligned.
    """
    verdict = _in_degrees(recording, v)
    if verdict is not None:
        return verdict
    if found.impossible:
        answer = "Not at all: no such robot moves like that."
        return RunVerdict(SURE, Mark.BAD, answer, too_fast(recording, found))
    verdict = _of_noise(v, flocking)
    lost, seen = what_is_lost(recording, found), who_is_seen(recording, losses)
    frozen = perhaps_frozen(of_robots(recording, found))
    if not lost and not seen and not frozen:
        return verdict
    shift = v.get("gamma_unseen", math.nan)
    by = f" They may shift γ from motion by up to {shift:.2g}." if shift >= 0.0005 else ""
    words = (lost, frozen, f"{seen}{by}" if seen else "", verdict.because)
    because = " ".join(filter(None, words))
    verdict = replace(verdict, because=because)
    if verdict.mark is Mark.BAD:
        return verdict
    if losses.seen < TOO_FEW:
        answer = "Little: most robots are not seen most of the time."
        return replace(verdict, mark=Mark.BAD, answer=answer)
    implausible = bool(found.jumps.any())
    small = losses.longest <= SHORT_LOSS and losses.seen >= NEARLY_ALL and not losses.never
    if implausible:
        answer = "Not everywhere: poses jump, as no wheels can."
    elif frozen:
        answer = "Not everywhere: poses freeze."
    elif small and not (shift > SMALL_SHIFT):
        return verdict
    else:
        answer = "Not everywhere: robots are not seen all the time."
    mark = verdict.mark if verdict.mark is Mark.UNKNOWN else Mark.CAUTION
    return replace(verdict, mark=mark, answer=answer)


def unseen_safety(
    verdict: RunVerdict, v: Mapping[str, float], recording: Run, losses: Losses
) -> RunVerdict:
    """Let a verdict of safety speak of the robots that are not seen, too.

    Nothing is known of a robot that is not seen, but that it drives no faster than its wheels turn:
    where it could not have come to anybody or to a wall in that time, it did not.

    Parameters
    ----------
    verdict : RunVerdict
        Of those that are seen.
    v : mapping of float
        Numbers by their keys.
    recording : Run
        Its robot, and how fast its wheels turn.
    losses : Losses
        What is lost of them.
    """
    seen = not losses.never and losses.longest <= HARMLESS
    if verdict.mark is not Mark.GOOD or seen:
        return verdict
    robot = recording.robot
    way = fastest(robot)[0] * losses.longest
    apart = v.get("smallest_collision_distance", math.inf) - robot.collision_diameter
    clear = apart >= way + 4 * robot.collision_offset and v["smallest_wall_distance"] >= way / 2
    if clear and not losses.never:
        return replace(
            verdict,
            because=f"{verdict.because} Who was not seen, for {losses.longest:.1f} s at most, "
            "could not come near enough to anything.",
        )
    who = who_is_seen(recording, losses) or f"Nobody is seen for {losses.longest:.1f} s."
    answer = "No collision and nobody outside, as far as robots are seen."
    because = f"{verdict.because} {who} What they did meanwhile is unknown."
    return replace(verdict, mark=Mark.CAUTION, answer=answer, because=because, short="safe as seen")


def _in_degrees(recording: Run, v: Mapping[str, float]) -> RunVerdict | None:
    """Judge headings that begin beyond a full turn, and that motion does not confirm."""
    headings = recording.poses[:, 2]
    known = np.isfinite(headings)
    first = headings[known.argmax(axis=0), np.arange(recording.robots)]
    begin = float(np.abs(first[known.any(axis=0)]).max(initial=0.0))
    if begin <= 2 * math.pi or not v["heading_offset"] > DOUBTFUL_HEADINGS:
        return None
    return RunVerdict(
        SURE,
        Mark.BAD,
        "Not at all: headings seem to be in degrees.",
        f"They begin at up to {begin:.3g}, which is no angle in radians, and robots do not move "
        "along them: report again with --degrees.",
    )


def _of_noise(v: Mapping[str, float], flocking: bool) -> RunVerdict:
    """Judge headings against motion, and what tracking noise takes from γ."""
    if v["heading_offset"] > WRONG_HEADINGS:
        return RunVerdict(
            SURE,
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
        return RunVerdict(SURE, Mark.UNKNOWN, "Too short to measure the noise.", gaps.strip())
    tracked = f"Tracking noise, measured in this log, is {length_text(noise)}"
    if not flocking:
        sharp = ties.within(noise, NOISY)
        mark, word = (Mark.GOOD, "sharp") if sharp else (Mark.CAUTION, "noisy")
        return RunVerdict(SURE, mark, f"Positions are {word}.", f"{tracked}.{gaps}")
    bias = v["gamma_bias"]
    if math.isnan(course):
        return RunVerdict(
            SURE,
            Mark.CAUTION,
            "Directions of motion are undefined.",
            f"{tracked}; nothing moves.{gaps}",
        )
    because = (
        f"{tracked}, so a direction of motion is sure to {angle_text(course)} and γ from "
        f"motion is under-read by {bias_text(bias)}; {band_sentence(v)} Raw differences read "
        f"{gamma_text(v['gamma_differences'])}.{gaps}"
    )
    if ties.beyond(v["left_out_motion"], 0.25):
        answer = "γ from motion speaks for few robots."
        return RunVerdict(
            SURE,
            Mark.CAUTION,
            answer,
            f"It leaves out {share_text(v['left_out_motion'])}. {because}",
        )
    if bias > 0.02:
        return RunVerdict(SURE, Mark.CAUTION, "γ from motion is noisy.", because)
    return RunVerdict(SURE, Mark.GOOD, "The estimate is sharp.", because)
