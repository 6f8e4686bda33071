"""How robots followed their commands: gains over the team."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.following import following_of
from posflock_robotarium.alignment.measured_run import MeasuredRun
from posflock_robotarium.alignment.metric_registry import NumberFunction, Scalar, register

Reduce = Callable[[NDArray[np.float64]], float]


def _gain(turn: bool, reduce: Reduce) -> NumberFunction:
    def number(run: MeasuredRun) -> float | None:
        found = run.once(following_of)
        if found is None or found.refused:
            return None
        gains = found.gains(turn)
        return float(reduce(np.array(gains))) if gains else float("nan")

    return number


def _known(turn: bool) -> NumberFunction:
    def number(run: MeasuredRun) -> int | None:
        found = run.once(following_of)
        return None if found is None or found.refused else len(found.gains(turn))

    return number


def _gains(key: str, words: str, turn: bool) -> tuple[Scalar, ...]:
    return (
        Scalar(
            f"{key}_gain",
            f"{words} gain",
            "",
            f"Achieved over commanded {words}, with dead time and lag taken into account: median "
            "over the robots of which the log determines it.",
            "Motion",
            _gain(turn, np.median),
        ),
        Scalar(
            f"{key}_gain_smallest",
            f"smallest {words} gain",
            "",
            "Of these robots.",
            "Motion",
            _gain(turn, np.min),
        ),
        Scalar(
            f"{key}_gain_largest",
            f"largest {words} gain",
            "",
            "Of these robots.",
            "Motion",
            _gain(turn, np.max),
        ),
        Scalar(
            f"{key}_gain_robots",
            f"robots with a {words} gain",
            "",
            "Robots whose commands and motion say enough; the others have none.",
            "Motion",
            _known(turn),
        ),
    )


register(*_gains("speed", "speed", turn=False))
register(*_gains("turn", "turn rate", turn=True))
