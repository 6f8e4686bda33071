"""What verify has to say: findings, each one reason in plain words, and their sum, the verdict.

A :class:`Finding` says what is wrong, where (a line of the source, or a time, robots and a
figure of a run), how bad that is, and what to do about it.  Its ``code`` is stable, for programs;
:class:`Code` lists them all.
"""

from __future__ import annotations

import enum
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from barrier_certificates.word_enum import WordEnum
from rps_compat import testbed


class Verdict(enum.IntEnum):
    """How bad; a note is worth knowing and costs nothing."""

    NOTE = 0
    PASS = 1
    RISK = 2
    FAIL = 3


class Code(WordEnum):
    """What a finding is about: a name that stays, for programs, and the same in words."""

    about: str

    def __new__(cls, name: str, about: str = "") -> Code:
        """Make a code of its name and of what it is about; `Code(name)` finds it again."""
        code = str.__new__(cls, name)
        code._value_ = name
        code.about = about
        return code

    # Seen in the source.
    SYNTAX = "syntax", "not valid Python"
    NEWER_PYTHON = (
        "newer-python",
        "syntax or a library feature newer than the testbed's Python 3.10",
    )
    REMOVED_FROM_NUMPY = "removed-from-numpy", "a name that the testbed's numpy no longer has"
    REMOVED_FROM_LIBRARY = (
        "removed-from-library",
        "a name that the testbed's version of a library or Python dropped",
    )
    NEWER_LIBRARY = "newer-library", "a name that came to a library after the testbed's version"
    REMOVED_LATER = (
        "removed-later",
        "a name that the testbed has and newer versions of a library have not",
    )
    LIBRARY_ABSENT = "library-absent", "imports a library that the testbed has not"
    MODULE_MISSING = "module-missing", "imports a file that is not there"
    LOCAL_MODULE = "local-module", "imports a file that must be uploaded too"
    STAND_IN = "stand-in", "imports the local stand-in for the simulator"
    SHADOWED_NAME = "shadowed-name", "a file hides a module of Python or of the testbed"
    GENERATION = "generation", "uses names of another generation of the API"
    TOO_MANY_ROBOTS = "too-many-robots", "asks for more robots than there are"
    BLOCKING_CALL = "blocking-call", "waits for somebody"
    SLOW_SLEEP = "slow-sleep", "sleeps longer than a time step in its loop"
    NO_FINISHING_CALL = "no-finishing-call", "never calls debug() or call_at_scripts_end()"
    SAVE_AT_END = "save-at-end", "saves data only after its loop"
    FILE_MISSING = "file-missing", "reads a file that is not there"
    FILE_ENDING = "file-ending", "reads a file whose ending may not be uploaded"
    FILE_IN_FOLDER = "file-in-folder", "reads a file from a folder, but uploads are flat"
    # Seen in runs.
    CRASH = "crash", "ends with an error"
    EXIT_CODE = "exit-code", "ends with an exit code that says failure"
    NO_STEP = "no-step", "never drives a robot"
    COLLISION = "collision", "robots come too close"
    BOUNDARY = "boundary", "robots leave the arena"
    ACTUATOR = "actuator", "commands exceed the wheels' limit"
    CLOSE_START = "close-start", "initial conditions closer than two robots may stand"
    UNREACHABLE_START = "unreachable-start", "initial conditions that cannot be driven to"
    SLOW_LOOP = "slow-loop", "its loop is slower than a time step"
    WATCHDOG = "watchdog", "leaves robots without a command so long that they brake"
    DURATION = "duration", "takes longer than declared, or than any run may"
    ENDLESS = "endless", "does not end by itself"
    DATA_LOST = "data-lost", "loses data when it is interrupted"
    HANG = "hang", "stops stepping"
    FORK = "fork", "starts other processes"
    MEMORY = "memory", "needs more memory than allowed"
    DISK = "disk", "writes or prints more than allowed"
    OUTSIDE_WRITE = "outside-write", "writes outside its own folder"
    NETWORK = "network", "uses the network"
    NO_TRIALS = "no-trials", "no run under imperfections was judged"
    NOTHING_SAVED = "nothing-saved", "leaves no data file"
    INTERNAL = "internal", "the verifier itself could not do something"


@dataclass(frozen=True)
class Finding:
    """One thing worth knowing before a submission.

    Attributes
    ----------
    code : Code
        What it is about.
    verdict : Verdict
        How bad.
    message : str
        What was seen, in words.
    advice : str
        What to do about it.
    line : int, optional
        Line of the source, from 1.
    file : str
        Its file, where that is not the script.
    time : float, optional
        Seconds into the run.
    robots : tuple of int
        Whom it concerns.
    figure : float, optional
        The number behind it, in `unit`.
    unit : str
        Of `figure`.
    trials : (int, int), optional
        In how many of how many trials.
    interval : (float, float), optional
        95 % confidence interval of the proportion of runs.
    """

    code: Code
    verdict: Verdict
    message: str
    advice: str = ""
    line: int | None = None
    file: str = ""
    time: float | None = None
    robots: tuple[int, ...] = ()
    figure: float | None = None
    unit: str = ""
    trials: tuple[int, int] | None = None
    interval: tuple[float, float] | None = None

    @property
    def where(self) -> str:
        """Place and time in few words, such as ``line 12`` or ``t = 31.2 s, robots 3, 7``."""
        parts = []
        if self.line is not None:
            parts.append(f"{self.file}:{self.line}" if self.file else f"line {self.line}")
        elif self.file:
            parts.append(self.file)
        if self.time is not None:
            parts.append(f"t = {self.time:.1f} s")
        if self.robots:
            parts.append(
                ("robot " if len(self.robots) == 1 else "robots ")
                + ", ".join(str(robot) for robot in self.robots)
            )
        return ", ".join(parts)

    def as_dict(self) -> dict[str, Any]:
        """Return what ``verify.json`` holds of it."""
        return {
            "code": self.code.value,
            "verdict": self.verdict.name,
            "message": self.message,
            "advice": self.advice,
            "line": self.line,
            "file": self.file or None,
            "time": self.time,
            "robots": list(self.robots),
            "figure": self.figure,
            "unit": self.unit or None,
            "trials": list(self.trials) if self.trials else None,
            "interval": list(self.interval) if self.interval else None,
        }


def count(number: int, thing: str) -> str:
    """Return how many of something there are, in words.

    Parameters
    ----------
    number : int
        How many.
    thing : str
        Of what, in the singular; the plural gets an s.

    Examples
    --------
    >>> count(1, "file"), count(2, "file")
    ('1 file', '2 files')
    """
    return f"{number} {thing}" + "s" * (number != 1)


def verdict_of(findings: Iterable[Finding]) -> Verdict:
    """Return the worst verdict, PASS where nothing is worse than a note.

    Parameters
    ----------
    findings : iterable of Finding
        What was found.
    """
    return max([Verdict.PASS, *(finding.verdict for finding in findings)])


def interval_text(interval: tuple[float, float] | None) -> str:
    """Return an interval of a proportion in per cent.

    Parameters
    ----------
    interval : pair of float, optional
        Its ends, from 0 to 1; None reads as a dash.
    """
    return "–" if interval is None else f"{100 * interval[0]:.0f} to {100 * interval[1]:.0f} %"


def too_many_robots(number: float, line: int | None = None) -> Finding:
    """Return the finding that a script asks for more robots than there are.

    Parameters
    ----------
    number : float
        Of robots.
    line : int, optional
        Of the source, where it shows the number.
    """
    return Finding(
        Code.TOO_MANY_ROBOTS,
        Verdict.FAIL,
        f"asks for {number} robots; the testbed has {testbed.MAX_ROBOTS}, though the simulator"
        " takes 50",
        f"use at most {testbed.MAX_ROBOTS}",
        line=line,
        figure=float(number),
        unit="robots",
    )
