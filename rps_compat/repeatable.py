"""Randomness that nobody seeded, made repeatable while a script runs.

A script that calls ``np.random.default_rng()`` without a seed asks the operating system for one, so
that every run differs. Under a seed of the run those seeds come from one stream instead. What is
meant to be secret stays so: ``secrets``, ``os.urandom``, ``random.SystemRandom``, ``uuid``.
"""

from __future__ import annotations

import contextlib
import random
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.random import bit_generator

#: Where seeds come from while a run is repeatable.
_stream: random.Random | None = None
_Random, _python_seed = random.Random, random.seed
_randbits = bit_generator.randbits  # type: ignore[attr-defined]
_numpy_seed = np.random.seed


class Repeatable(random.Random):
    """``random.Random``, with a seed from the run's stream where it is given none.

    Parameters
    ----------
    x : object
        The seed; None, which Python takes from the system, is drawn from the run's stream.
    """

    def __init__(self, x: Any = None) -> None:
        super().__init__(_or_drawn(x, 64))

    def seed(self, a: Any = None, version: int = 2) -> None:
        """Seed it.

        Parameters
        ----------
        a : object
            The seed; None is drawn from the run's stream.
        version : int
            As in `random.Random.seed`.
        """
        super().seed(_or_drawn(a, 64), version)


def _or_drawn(seed: Any, bits: int) -> Any:
    return seed if seed is not None or _stream is None else _stream.getrandbits(bits)


def _seed(a: Any = None, version: int = 2) -> None:
    _python_seed(_or_drawn(a, 64), version)


def _seed_numpy(seed: Any = None) -> None:
    _numpy_seed(_or_drawn(seed, 32))


def seed_global_generators(seed: int) -> None:
    """Seed Python's and numpy's global generators, which scripts draw from.

    Parameters
    ----------
    seed : int
        The seed, not negative.
    """
    random.seed(seed)
    np.random.seed(seed % 2**32)  # noqa: NPY002


def _drawn(bits: int) -> int:
    return _randbits(bits) if _stream is None else _stream.getrandbits(bits)


def _stream_of(seed: int, process: tuple[int, ...] = ()) -> random.Random:
    return _Random(f"unseeded generators of run {seed}{process or ''}")


def restart(seed: int, process: tuple[int, ...]) -> None:
    """Give a child process of a repeatable run a stream of its own.

    Parameters
    ----------
    seed : int
        Of the run.
    process : tuple of int
        What tells this process from others of the run.
    """
    global _stream
    if _stream is not None:
        _stream = _stream_of(seed, process)


@contextlib.contextmanager
def repeatable(seed: int | None) -> Iterator[None]:
    """Let generators that get no seed be repeatable within the ``with`` block.

    Parameters
    ----------
    seed : int, optional
        Of the stream that their seeds come from; None leaves them to the operating system.
    """
    global _stream
    if seed is None:
        yield
        return
    before, _stream = _stream, _stream_of(seed)
    random.Random, random.seed = Repeatable, _seed  # type: ignore[misc]
    np.random.seed = _seed_numpy
    # numpy asks `randbits` for the entropy of every SeedSequence() that is given none.
    bit_generator.randbits = _drawn  # type: ignore[attr-defined]
    try:
        yield
    finally:
        _stream = before
        random.Random, random.seed = _Random, _python_seed  # type: ignore[misc]
        np.random.seed = _numpy_seed
        bit_generator.randbits = _randbits  # type: ignore[attr-defined]
