"""What a report is asked about a run: did it flock, keep a formation, cover the arena, or neither.

Whether a run was safe, within limits and whole can be told of any; whether it aligned is asked only
of what is known to be a flock, lest a script that never meant to flock be told that it failed.
"""

from __future__ import annotations

from dataclasses import dataclass

from barrier_certificates.word_enum import WordEnum
from posflock_robotarium.logs.run import Run


class Questions(WordEnum):
    """What is asked beside safety, limits, certainty and whether the run is whole."""

    FLOCKING = "flocking"
    FORMATION = "formation"
    COVERAGE = "coverage"
    NONE = "none"


class ChosenBy(WordEnum):
    """Where it is known from what to ask."""

    USER = "user"
    RADIUS = "radius"
    LOG = "log"
    DEFAULT = "default"


_REASONS = {
    ChosenBy.USER: "as --questions says",
    ChosenBy.RADIUS: "since --radius was given",
    ChosenBy.LOG: "since the log says a neighbour radius",
    ChosenBy.DEFAULT: "since the log says no neighbour radius (--questions asks more)",
}


@dataclass(frozen=True)
class Asked:
    """What a run is asked, and why.

    Attributes
    ----------
    questions : Questions
        What is asked.
    by : ChosenBy
        Where that is known from.
    """

    questions: Questions
    by: ChosenBy

    @property
    def reason(self) -> str:
        """Why this is asked and nothing else, in words."""
        return _REASONS[self.by]


def asked_of(recording: Run, questions: Questions | None, radius: object = None) -> Asked:
    """Return what to ask of a run: what the user says, or what its log tells.

    Parameters
    ----------
    recording : Run
        The run; the log of a flock says its neighbour radius.
    questions : Questions or None
        What the user asks.
    radius : float or (N,) array, optional
        Neighbour radius that the user gave, m; who gives one asks about neighbours.
    """
    if questions is not None:
        return Asked(questions, ChosenBy.USER)
    if radius is not None:
        return Asked(Questions.FLOCKING, ChosenBy.RADIUS)
    if recording.parameters.get("neighbour_radius") is not None:
        return Asked(Questions.FLOCKING, ChosenBy.LOG)
    return Asked(Questions.NONE, ChosenBy.DEFAULT)
