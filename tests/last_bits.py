"""Inputs that differ from each other by their last bits alone, as from processor to processor.

A test asks for the same answer to all of them. It stands *at* a tie, where without a stated rule
the last bit decides, so that half of the neighbours of an input get the other answer.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from rps_compat.testbed import GTERNAL

#: Metres between the centres of two robots, face to face, that are just too close.
TOUCHING = GTERNAL.collision_diameter + 2 * GTERNAL.collision_offset
#: Units in the last place by which processors, numpys and orders of summation differ.
ULPS = (1, 2, 4)


def shifted(values: Any, ulps: int) -> np.ndarray:
    """Floats that are so many units in the last place above `values`, or below."""
    out = np.array(values, dtype=float)
    for _ in range(abs(ulps)):
        out = np.nextafter(out, np.copysign(np.inf, ulps))
    return out


def neighbours_of(values: Any) -> Iterator[np.ndarray]:
    """`values`, all numbers a little up, all a little down, and each its own way."""
    yield np.array(values, dtype=float)
    rng = np.random.default_rng(0)
    for ulps in ULPS:
        up, down = shifted(values, ulps), shifted(values, -ulps)
        yield up
        yield down
        for _ in range(4):
            yield np.where(rng.random(np.shape(values)) < 0.5, up, down)
