"""Where this package deliberately answers differently from the published simulators.

The published code has defects that hurt the people who meet them: an answer of NaN, a limit that is
ignored, a caller's array that is changed. There, our answer is the right one. The testbed runs the
published code, though, so a rehearsal may want it faithful to the letter::

    from rps_compat import deviations

    with deviations.all_as_published():
        ...                                # bug for bug

or set the environment variable ``RPS_COMPAT_AS_PUBLISHED=1`` before Python starts. Every deviation
stands in :data:`DEVIATIONS`, and nothing deviates that does not stand there.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass


@dataclass(frozen=True)
class Deviation:
    """One defect: in which functions, what is published, and what we do."""

    generation: int
    functions: tuple[str, ...]
    published: str
    ours: str


DEVIATIONS: dict[str, Deviation] = {
    "pose controller at angle zero": Deviation(
        1,
        ("create_clf_unicycle_pose_controller",),
        "a robot that looks exactly at its goal, or stands on it, gets the turn rate NaN (0/0)",
        "the limit of the formula, a finite turn rate",
    ),
    "at_position": Deviation(
        1,
        ("at_position",),
        "every call with well-formed arguments raises NameError",
        "who is at their points, as documented",
    ),
}

_as_published = os.environ.get("RPS_COMPAT_AS_PUBLISHED", "") not in ("", "0")


def as_published(name: str) -> bool:
    """Whether the deviation `name` is switched off, so that the published defect is wanted."""
    assert name in DEVIATIONS, f"{name!r} is not listed in DEVIATIONS"
    return _as_published


@contextmanager
def all_as_published(wanted: bool = True) -> Iterator[None]:
    """Within the block, answer as the published simulators do, defects included."""
    global _as_published
    before, _as_published = _as_published, wanted
    try:
        yield
    finally:
        _as_published = before
