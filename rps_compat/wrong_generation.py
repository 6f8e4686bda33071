"""Names of one generation asked of the other: answered at once, and with the right name."""

from collections.abc import Callable
from functools import wraps
from typing import Any, NoReturn, ParamSpec

from rps_compat.errors import WrongArgumentError, WrongGenerationError
from rps_compat.scripts.generation_names import (
    METHODS,
    NEW_ARGUMENTS,
    OLD_ARGUMENTS,
    OLD_ATTRIBUTES,
    counterpart,
)

_Arguments = ParamSpec("_Arguments")


def refuse(instance: Any, name: str, generation: int) -> NoReturn:
    """Answer a missing attribute, with the right name where the other generation has one.

    Parameters
    ----------
    instance : object
        What was asked for it.
    name : str
        Name of the attribute.
    generation : int
        Of the API whose object it is: 1 or 2.

    Raises
    ------
    WrongGenerationError
        `name` belongs to the other generation.
    AttributeError
        `name` belongs to neither.
    """
    kind = type(instance).__name__
    right = counterpart(name, generation)
    if right is None:
        raise AttributeError(f"{kind!r} object has no attribute {name!r}")
    whose = (
        "in the API of 2017 to 2019"
        if name in OLD_ATTRIBUTES
        else f"in generation {3 - generation} of the API"
    )
    call = "()" if right in METHODS else ""
    raise WrongGenerationError(
        f"{kind!r} object has no attribute {name!r}: that is the name {whose}; generation "
        f"{generation} calls this {right}{call}"
    )


def refuse_new_arguments(constructor: Callable[_Arguments, None]) -> Callable[_Arguments, None]:
    """Let a constructor of generation 1 answer arguments of generation 2 in words.

    Parameters
    ----------
    constructor : callable
        An ``__init__`` that takes the published arguments.

    Raises
    ------
    WrongArgumentError
        It is a TypeError, as Python's own answer to an unknown argument.
    """

    @wraps(constructor)
    def checked(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> None:
        for name in kwargs:
            if name in OLD_ARGUMENTS:
                new = OLD_ARGUMENTS[name]
                raise WrongArgumentError(
                    f"Robotarium of generation 1 has no argument {name!r}: that is of the API of "
                    f"2017 to 2019; {f'write {new}' if new else 'leave it out'}"
                )
            if name in NEW_ARGUMENTS:
                raise WrongArgumentError(
                    f"Robotarium of generation 1 has no argument {name!r}: that is generation 2's: "
                    "run with --generation 2, or rps_compat.install(generation=2)"
                )
        constructor(*args, **kwargs)

    return checked
