"""Names of one generation asked of the other: answered at once, and with the right name."""

from typing import Any, NoReturn

from rps_compat.errors import WrongGenerationError
from rps_compat.generations import ATTRIBUTES

#: Attributes of an instance: generation 1's name → generation 2's.
RENAMED = ATTRIBUTES

_RIGHT = {1: {new: old for old, new in ATTRIBUTES.items()}, 2: ATTRIBUTES}


def refuse(instance: Any, name: str, generation: int) -> NoReturn:
    """Raise for a missing attribute `name`, with the right name where the other generation has one.

    Raises
    ------
    WrongGenerationError
        `name` belongs to the other generation.
    AttributeError
        `name` belongs to neither.
    """
    kind = type(instance).__name__
    right = _RIGHT[generation].get(name)
    if right is None:
        raise AttributeError(f"{kind!r} object has no attribute {name!r}")
    call = "()" if name in ("call_at_scripts_end", "debug") else ""
    raise WrongGenerationError(
        f"{kind!r} object has no attribute {name!r}: that is the name in generation "
        f"{3 - generation} of the API; generation {generation} calls this {right}{call}"
    )
