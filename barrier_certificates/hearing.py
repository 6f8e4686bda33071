"""Who hears what certificates answer: by default nobody.

A certificate is asked somewhere in the middle of a script, which uses the answer and drops it. Who
runs that script and wants to show or to log what certificates did says so around it, and hears of
every certificate that the process asks::

    def show(answer: Answer) -> None:
        print(answer.info.status, answer.info.active)

    with heard_by(show):
        runpy.run_path("script.py")
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from barrier_certificates.array_types import FloatArray

if TYPE_CHECKING:  # who listens need not wait for the solvers
    from barrier_certificates.projection import ProjectionInfo


@dataclass(frozen=True, eq=False)
class Answer:
    """What a certificate was asked, and what it answered.

    The arrays, and the rows of `info`, are the certificate's own: copy what is kept.

    Attributes
    ----------
    desired : (2, N) array
        Velocities of the points that are kept apart, as they were asked for, m/s.
    velocity : (2, N) array
        The safe ones, m/s.
    info : ProjectionInfo
        What was done.
    """

    desired: FloatArray
    velocity: FloatArray
    info: ProjectionInfo


Hearer = Callable[[Answer], None]

_hearers: tuple[Hearer, ...] = ()


@contextlib.contextmanager
def heard_by(hearer: Hearer) -> Iterator[None]:
    """Let somebody hear each answer within the ``with`` block, whichever certificate gives it.

    Parameters
    ----------
    hearer : callable
        Is called with each `Answer`, in the thread that asked; what it raises, the asker gets.
    """
    global _hearers
    before, _hearers = _hearers, (*_hearers, hearer)
    try:
        yield
    finally:
        _hearers = before


def tell(desired: FloatArray, velocity: FloatArray, info: ProjectionInfo) -> None:
    """Let who listens hear an answer.

    Parameters
    ----------
    desired : (2, N) array
        Velocities that were asked for, m/s.
    velocity : (2, N) array
        The safe ones, m/s.
    info : ProjectionInfo
        What was done.
    """
    for hearer in _hearers:
        hearer(Answer(desired, velocity, info))
