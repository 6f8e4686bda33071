"""Who attends a flock while it flies: on the testbed, nobody.

A program around a script, such as a page in a browser, may look at a flock between two steps and
give it another law. It says so once, around the script, and is shown every flock of the process
when it is made and before each of its steps::

    def widen(flock: Attended) -> None:
        flock.retune(replace(flock.law, radius=1.0), flock.model)

    with attended_by(widen):
        runpy.run_path("robotarium_9bot.py")
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.law import LawParameters
from posflock_robotarium.flocking.paper_models import Model


class Attended(Protocol):
    """A flock as who attends it sees it.

    Attributes
    ----------
    law : LawParameters
        Which parameters it follows.
    model : Model
        Which of the paper's models it follows.
    """

    law: LawParameters
    model: Model

    @property
    @abstractmethod
    def links(self) -> NDArray[np.bool_] | None:
        """Who was whose neighbour at the last step, (N, N); None before the first."""

    @abstractmethod
    def retune(self, law: LawParameters, model: Model) -> None:
        """Follow another law from the next step on.

        Parameters
        ----------
        law : LawParameters
            δ, r, k and the limits.
        model : Model
            Which of the paper's models.

        Raises
        ------
        ParameterError
            Where the flock cannot follow it; it goes on as before.
        """


Attendant = Callable[[Attended], None]

_attendants: tuple[Attendant, ...] = ()


@contextmanager
def attended_by(attendant: Attendant) -> Iterator[None]:
    """Show somebody every flock within the ``with`` block.

    Parameters
    ----------
    attendant : callable
        Is called with each flock when it is made and before each of its steps.
    """
    global _attendants
    before, _attendants = _attendants, (*_attendants, attendant)
    try:
        yield
    finally:
        _attendants = before


def show(flock: Attended) -> None:
    """Show a flock to those who attend.

    Parameters
    ----------
    flock : Attended
        Which is between two steps.
    """
    for attendant in _attendants:
        attendant(flock)
