"""Did robots do as they were told? The gains of speed and turn rate, in words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from barrier_certificates import ties
from posflock_robotarium.alignment.run_verdict import Mark, RunVerdict

QUESTION = "Did robots do as they were told?"
OFF = 0.1
"""How far from 1 a gain may be before it is worth a warning: robots of one make differ by less."""

_WORDS = {"speed": "speed", "turn": "turn rate"}


def following_verdict(v: Mapping[str, float]) -> Iterator[RunVerdict]:
    """Judge how robots followed their commands; nothing where no log tells it.

    Parameters
    ----------
    v : mapping of float
        Values of the numbers by key.
    """
    speed, turn = (v.get(f"{key}_gain", math.nan) for key in ("speed", "turn"))
    if math.isnan(speed) and math.isnan(turn):
        return
    told = "; ".join(_told(v, key, words) for key, words in _WORDS.items())
    because = f"{told[0].upper()}{told[1:]}. Being late (dead time, lag) is not counted."
    off = [gain for gain in (speed, turn) if ties.beyond(abs(gain - 1), OFF)]
    if not off:
        known = [words for key, words in _WORDS.items() if v[f"{key}_gain_robots"]]
        yield RunVerdict(QUESTION, Mark.GOOD, f"Yes, in {' and '.join(known)}.", because)
    elif speed in off:
        answer = f"No: they drove {speed:.2f} of the speed they were told."
        yield RunVerdict(QUESTION, Mark.CAUTION, answer, because)
    else:
        answer = f"No: they turned at {turn:.2f} of the rate they were told."
        yield RunVerdict(QUESTION, Mark.CAUTION, answer, because)


def _told(v: Mapping[str, float], key: str, words: str) -> str:
    known, robots = int(v[f"{key}_gain_robots"]), int(v["robots"])
    if not known:
        return f"the {words} gain of no robot is determined: commands vary too little"
    low, high = v[f"{key}_gain_smallest"], v[f"{key}_gain_largest"]
    of = "robots" if known == robots else f"{known} of {robots} robots, the others say too little"
    return f"the {words} gain is {v[f'{key}_gain']:.2f} ({low:.2f} to {high:.2f} over {of})"
