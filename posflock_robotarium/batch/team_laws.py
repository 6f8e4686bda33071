"""The parameters of many flocks' laws as arrays, so that flocks of different ones fly together.

The functions of `flocking.law` take parameters that broadcast against what they are for: one number
for all flocks, one for each agent, (n,), or one for each flock, (B, 1). Each flock's numbers meet
its own robots in the same operations as they would alone, so that they come out the same to the
last bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields

import numpy as np

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import LawParameters


class _TeamLaws(LawParameters):
    """Parameters of B laws, as (B, 1) or (B, n) arrays; each was checked by itself."""

    def __init__(self, laws: Sequence[LawParameters]) -> None:
        for field in fields(LawParameters):
            values = [np.atleast_1d(getattr(law, field.name)) for law in laws]
            sizes = sorted({value.size for value in values} - {1})
            if len(sizes) > 1:
                raise ParameterError(
                    f"laws: expected teams of one size, got {field.name} for {sizes[0]} and for"
                    f" {sizes[1]} agents"
                )
            # The type of `persistence` is a number's: `phi` alone uses it, and takes arrays.
            object.__setattr__(self, field.name, np.stack(np.broadcast_arrays(*values)))
        self._laws: tuple[LawParameters, ...]
        object.__setattr__(self, "_laws", tuple(laws))

    def agents_must_be(self, agents: int) -> None:
        for law in self._laws:
            law.agents_must_be(agents)


def law_of_teams(laws: Sequence[LawParameters]) -> LawParameters:
    """Return parameters of many laws as those of one batch.

    Parameters
    ----------
    laws : sequence of B LawParameters
        One a team, one at least.

    Raises
    ------
    ParameterError
        Where they are for teams of different sizes.
    """
    if all(law.as_dict() == laws[0].as_dict() for law in laws):
        return laws[0]
    return _TeamLaws(laws)
