"""What the processes of a run are called, and how their random numbers differ.

A process of `multiprocessing` has the number that its parent gave it: ``process-1``, and
``process-1.2`` the second one that this has started. The n-th that a process forked by itself is
``fork-n``, and one that was started afresh has the name of its script: ``worker-n``. So equal runs
have equal names, as far as they start their processes in the same order.

Generators are seeded from the run's seed and numbers that tell the process from all others.
"""

import os
import random
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from rps_compat.repeatable import restart, seed_global_generators


@dataclass(frozen=True)
class Name:
    """Name of one process of a run.

    Attributes
    ----------
    text
        Empty for the script's own process.
    entropy
        Numbers that tell its random numbers from others'.
    identity
        What `multiprocessing` called the process when it got this name.
    """

    text: str = ""
    entropy: tuple[int, ...] = ()
    identity: tuple[int, ...] = ()

    def of_multiprocessing(self, identity: tuple[int, ...]) -> "Name":
        """Name a process that `multiprocessing` has started below this one.

        Parameters
        ----------
        identity : tuple of int
            What `multiprocessing` calls it, ``Process._identity``.
        """
        own = identity[len(self.identity) :]
        numbers = ".".join(map(str, own))
        text = numbers if self.identity else f"process-{numbers}"
        return Name(_below(self.text, text), self.entropy + own, identity)

    def of_fork(self, number: int, identity: tuple[int, ...]) -> "Name":
        """Name a process that this one forked by itself.

        Parameters
        ----------
        number : int
            The how manieth it is, from 1.
        identity : tuple of int
            What `multiprocessing` calls the forking process.
        """
        return Name(_below(self.text, f"fork-{number}"), (*self.entropy, 0, number), identity)

    def of_script(self, script: str) -> "Iterator[Name]":
        """Name a process of the run that runs another script: the first one, the second, ...

        Parameters
        ----------
        script : str
            The script's path; may be empty.
        """
        stem = re.sub(r"\W", "_", Path(script).stem) or "python"
        return (Name(f"{stem}-{number}", (0, 0, number)) for number in count(1))

    def or_similar(self) -> "Iterator[Name]":
        """Name this, and then what a process may be called whose name is taken."""
        yield self
        for number in count(2):
            entropy = (*self.entropy, 0, 0, number)
            yield Name(f"{self.text}+{number}", entropy, self.identity)


def _below(above: str, name: str) -> str:
    return f"{above}.{name}" if above else name


def claim(room: Path, candidates: Iterator[Name]) -> Name:
    """Take for this process the first name that no other process has.

    Parameters
    ----------
    room : Path
        Folder of the run's records.
    candidates : iterator of Name
        Names to try; endless.

    Raises
    ------
    AssertionError
        If the candidates end.
    """
    for name in candidates:
        try:
            place = os.open(room / f"{name.text}.process", os.O_CREAT | os.O_EXCL | os.O_WRONLY)
        except FileExistsError:
            continue
        os.write(place, str(os.getpid()).encode())
        os.close(place)
        return name
    raise AssertionError("there is always one more name")


def identity() -> tuple[int, ...]:
    """How `multiprocessing` calls this process; empty where it has not started it."""
    process = _multiprocessing()
    return () if process is None else tuple(getattr(process, "_identity", ()))


def is_forked_by_multiprocessing() -> bool:
    """Whether the fork that this process comes from, and is in, is one of `multiprocessing`'s."""
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and str(frame.f_globals.get("__name__")).startswith("rps_compat."):
        frame = frame.f_back
    name = "" if frame is None else str(frame.f_globals.get("__name__"))
    return name.startswith("multiprocessing.")


def keep_error(errors: list[BaseException]) -> None:
    """Have the error put into `errors` by which the work of `multiprocessing` ends, if one does.

    Before Python 3.13 it can be seen when the process ends, and nothing needs to be done.

    Parameters
    ----------
    errors : list of exception
        Where the error is put.
    """
    process = _multiprocessing()
    if "_exit_function" in type(process)._bootstrap.__code__.co_names:
        return
    work = process.run

    def run() -> None:
        try:
            work()
        except BaseException as error:
            errors.append(error)
            if error.__traceback__ is not None:  # the script's traceback does without this line
                error.__traceback__ = error.__traceback__.tb_next
            raise

    process.run = run


def _multiprocessing() -> Any:
    module = sys.modules.get("multiprocessing.process")
    return None if module is None else module.current_process()


def seed_generators(seed: int | None, entropy: tuple[int, ...] = ()) -> None:
    """Seed Python's and numpy's global generators, unless the run has no seed.

    Generators that the process makes without a seed have others than those of its parent.

    Parameters
    ----------
    seed : int or None
        Seed of the run.
    entropy : tuple of int
        What tells this process from the others of the run.
    """
    if seed is None:
        return
    restart(seed, entropy)
    if not entropy:
        seed_global_generators(seed)
        return
    state = np.random.SeedSequence([seed, *entropy]).generate_state(4)
    random.seed(state.tobytes())
    np.random.seed(state)  # noqa: NPY002
