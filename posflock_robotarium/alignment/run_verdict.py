"""One sentence about a run, and how the run does by it."""

from __future__ import annotations

from dataclasses import dataclass

from barrier_certificates.word_enum import WordEnum


class Mark(WordEnum):
    """How a run does."""

    GOOD = "good"
    CAUTION = "caution"
    BAD = "bad"
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class RunVerdict:
    """One sentence about the run.

    Attributes
    ----------
    question : str
        What it answers.
    mark : Mark
        How the run does.
    answer : str
        A few words.
    because : str
        The figures it rests on.
    short : str
        One or two words for a headline or a table of runs; empty for the lesser questions.
    """

    question: str
    mark: Mark
    answer: str
    because: str
    short: str = ""
