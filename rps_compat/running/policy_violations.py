"""What a script may not do on the testbed, and where it did."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from barrier_certificates.word_enum import WordEnum


class PolicyKind(WordEnum):
    """What policy may forbid a script.

    `BLOCKING_CALL` it only takes note of; of `MEMORY` and `DISK` there may be too much, as whoever
    watches from outside finds.
    """

    OUTSIDE_WRITE = "outside-write"
    FORK = "fork"
    NETWORK = "network"
    BLOCKING_CALL = "blocking-call"
    MEMORY = "memory"
    DISK = "disk"


@dataclass(frozen=True)
class PolicyViolation:
    """What a script did that it must not do.

    Attributes
    ----------
    kind
        What is forbidden.
    what
        What it asked for.
    line, file
        Of the script's own files; None and empty where none of them asked.
    time
        Seconds of the run.
    """

    kind: PolicyKind
    what: str
    line: int | None = None
    file: str = ""
    time: float = 0.0


def read_violation(table: dict[str, Any]) -> PolicyViolation:
    """Return the violation that `dataclasses.asdict` gave, or JSON of it.

    Parameters
    ----------
    table : dict
        What it gave.
    """
    return PolicyViolation(**table | {"kind": PolicyKind(table["kind"])})
