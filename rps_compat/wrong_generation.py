"""Names of one generation asked of the other: answered at once, and with the right name."""

from collections.abc import Callable
from functools import wraps
from typing import Any, NoReturn, ParamSpec

from rps_compat.errors import WrongArgumentError, WrongGenerationError
from rps_compat.generations import ATTRIBUTES, NEW_ARGUMENTS

#: Attributes of an instance: generation 1's name → generation 2's.
RENAMED = ATTRIBUTES

_Arguments = ParamSpec("_Arguments")
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


def refuse_new_arguments(constructor: Callable[_Arguments, None]) -> Callable[_Arguments, None]:
    """Let the `constructor` of generation 1 answer arguments of generation 2 in words.

    Raises
    ------
    WrongArgumentError
        It is a TypeError, as Python's own answer to an unknown argument.
    """

    @wraps(constructor)
    def checked(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> None:
        for name in kwargs:
            if name in NEW_ARGUMENTS:
                raise WrongArgumentError(
                    f"Robotarium of generation 1 has no argument {name!r}: that is generation 2's: "
                    "run with --api 2, or rps_compat.install(api=2)"
                )
        constructor(*args, **kwargs)

    return checked
