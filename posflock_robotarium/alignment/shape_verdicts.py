"""What is said of a formation, and of coverage, where a run is asked about them."""

from __future__ import annotations

import math
from collections.abc import Mapping

from barrier_certificates import ties
from posflock_robotarium.alignment.catalogue.coverage import SPACING
from posflock_robotarium.alignment.catalogue.formation import KEPT
from posflock_robotarium.alignment.run_verdict import Mark, RunVerdict
from posflock_robotarium.alignment.verdict_words import since_text

MOVED = 0.05
"""Share of robots and time that must move for a shape to have been taken up."""


def kept_formation(v: Mapping[str, float]) -> RunVerdict:
    """Say whether the team took up a shape and kept it.

    Parameters
    ----------
    v : mapping of float
        Numbers of the run by key.
    """
    question = "Did it take up a formation and keep it?"
    if "shape_kept_from" not in v:
        return RunVerdict(question, Mark.UNKNOWN, "One robot has no formation.", "")
    end, since = v["shape_change_end"], v["shape_kept_from"]
    if math.isnan(end):
        answer = "Unknown: no two robots are seen at the end."
        return RunVerdict(question, Mark.UNKNOWN, answer, "")
    far = f"up to {end:.3f} m" if end >= 0.001 else "less than a millimetre"
    because = (
        f"Over the last tenth of the run, distances are {far} (root mean square) off "
        f"their means. Whether the shape is the one that was meant, a metric of your own tells."
    )
    if math.isnan(since) or ties.beyond(end, KEPT):
        return RunVerdict(
            question, Mark.BAD, "No: distances change to the end.", because, "no shape"
        )
    if since > 0:
        answer = f"Yes, {since_text(since, v.get('drive_in_log', 0.0))}."
        return RunVerdict(question, Mark.GOOD, answer, because, "in shape")
    if ties.beyond(v["standing"], 1.0 - MOVED):
        answer = "It kept the shape that it began with: nothing moves."
        return RunVerdict(question, Mark.CAUTION, answer, because, "stood in shape")
    return RunVerdict(question, Mark.GOOD, "Yes, throughout.", because, "in shape")


def covered(v: Mapping[str, float]) -> RunVerdict:
    """Say whether the team covers the arena.

    Parameters
    ----------
    v : mapping of float
        Numbers of the run by key.
    """
    question = "Does it cover the arena?"
    start, end, offset = v["coverage_start"], v["coverage_end"], v["cell_offset_end"]
    if math.isnan(end):
        answer = "Unknown: not all robots are seen at the end."
        return RunVerdict(question, Mark.UNKNOWN, answer, "")
    because = (
        f"A place is {start:.3f} m from the nearest robot on average at the start, {end:.3f} m at "
        "the end, every place counting alike."
    )
    if math.isnan(offset):
        because += " Some robot is nearest to no place."
    else:
        because += (
            f" At the end, robots are up to {offset:.3f} m from the centroids of their cells."
        )
    # Half a place: the centroid of a cell is no better known.
    if ties.within(offset, KEPT + SPACING / 2):
        return RunVerdict(question, Mark.GOOD, "Yes, evenly.", because, "covering")
    if ties.short_of(end, start):
        answer = "Better than at the start, not evenly."
        return RunVerdict(question, Mark.CAUTION, answer, because, "covering in part")
    return RunVerdict(question, Mark.BAD, "No better than at the start.", because, "not covering")
