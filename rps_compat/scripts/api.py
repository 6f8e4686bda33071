"""Names of the Robotarium's API: which generations have them, and what others have instead."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from rps_compat.scripts.exports import handed_on
from rps_compat.scripts.faces import API_MODULES, face, has, parameters
from rps_compat.scripts.generation_names import (
    ATTRIBUTES,
    CONSTRUCTOR,
    FUNCTIONS,
    METHODS,
    MODULES,
    NEW_ARGUMENTS,
    NEW_ATTRIBUTES,
    NEW_FUNCTIONS,
    OLD_ARGUMENTS,
    OLD_ATTRIBUTES,
    OLD_FUNCTIONS,
    OTHER_SHAPE,
    RENAMED_PARAMETERS,
    counterpart,
)

BOTH = frozenset({1, 2})


class Role(enum.Enum):
    """What a name of the API is the name of."""

    FUNCTION = "function"
    ATTRIBUTE = "attribute"
    ARGUMENT = "argument"
    POSITIONAL = "positional arguments"
    MODULE = "module"
    STAR = "star"


@dataclass(frozen=True)
class ApiName:
    """A name of the API.

    Attributes
    ----------
    name : str
        As the script writes it; of an argument without the ``=``.
    role : Role
        What it names.
    generations : frozenset of int
        Where it works: 1, 2, and 0 for the API of 2017 to 2019. Empty: nowhere.
    of : str
        The function, of an argument; the modules, of a name that a star brings.
    """

    name: str
    role: Role
    generations: frozenset[int]
    of: str = ""

    @property
    def shown(self) -> str:
        """The name as it is told."""
        if self.role is Role.ARGUMENT:
            return f"{self.name}= of {self.of}"
        if self.role is Role.POSITIONAL:
            return f"{self.of}(…) with arguments by position"
        return f"{self.name}()" if self.name in METHODS else self.name

    def stops(self, generation: int) -> bool:
        """Return whether a script stops at this name.

        Parameters
        ----------
        generation : int
            Of the API: 1 or 2.
        """
        return generation not in self.generations

    @property
    def what(self) -> str:
        """Whose name it is, in words."""
        if not self.generations:
            return f"{self.shown} is in no generation of the API"
        newest = max(self.generations)
        whose = "the API of 2017 to 2019" if newest == 0 else f"generation {newest}"
        if self.role is Role.STAR:
            return f"{self.name} comes from a star import of {whose}"
        return f"{self.shown} is {whose}'s" if newest else f"{self.shown} is of {whose}"

    def remedy(self, generation: int) -> str:
        """Return what to do about it, in words.

        Parameters
        ----------
        generation : int
            Of the API: 1 or 2.
        """
        has = f"generation {generation}"
        if not self.generations:
            return "correct the name"
        if self.role is Role.POSITIONAL:
            return f"{has} takes them by name only"
        if self.role is Role.ARGUMENT:
            if 0 in self.generations:
                new = OLD_ARGUMENTS[self.name] if self.of == "Robotarium" else None
                return f"write {new}=" if new else "leave it out"
            new = renamed_parameters(self.of, generation).get(self.name)
            return f"{has} calls it {new}=" if new else f"{has} has no such argument"
        right = self.right(generation)
        if self.role is Role.STAR and right is None:
            return f"that of {has} does not bring it: {import_of(self.name, generation)}"
        if right is None:
            return f"{has} has nothing like it"
        shape = f"; {OTHER_SHAPE[self.name]}" if self.name in OTHER_SHAPE else ""
        return f"{has} calls it {right}{'()' if right in METHODS else ''}{shape}"

    def right(self, generation: int) -> str | None:
        """Return what a generation calls it; None where it has nothing like it.

        Parameters
        ----------
        generation : int
            Of the API: 1 or 2.
        """
        if self.role is Role.MODULE:
            return MODULES.get(self.name, (0, None))[1]
        return counterpart(self.name, generation)


def renamed_parameters(function: str, generation: int) -> dict[str, str]:
    """Return parameters of a function that the other generation has under other names.

    Required ones keep their places, so they are matched by those: ``N`` → ``n``. Optional ones are
    not: what stands in one's place is often something else.

    Parameters
    ----------
    function : str
        What the generation other than `generation` calls it.
    generation : int
        1 or 2.
    """
    new = counterpart(function, generation) or function
    old, fresh = parameters(function, 3 - generation), parameters(new, generation)
    found = {
        name: target
        for (name, required), target in zip(old.items(), fresh, strict=False)
        if required and name not in fresh and target not in old
    }
    return found | (RENAMED_PARAMETERS.get(new, {}) if generation == 2 else {})


def import_of(name: str, generation: int) -> str:
    """Return the import by which a script gets what a star brought before.

    Parameters
    ----------
    name : str
        What the star brought.
    generation : int
        Of the API: 1 or 2.
    """
    home = handed_on(name)
    if home is None:
        module = next((m for m in API_MODULES if has(m, name, generation)), "rps.utilities")
        return f"from {module} import {name}"
    if home == name:
        return f"import {name}"
    parent, _, last = home.rpartition(".")
    if name == last:
        return f"from {parent} import {name}"
    return f"import {home} as {name}"


def brings(module: str, name: str, generation: int) -> bool:
    """Return whether the star of a module of the API brings a name.

    Parameters
    ----------
    module : str
        Dotted name of the module.
    name : str
        Name without dots.
    generation : int
        Of the API: 1 or 2.
    """
    found = face(module, generation)
    return found is not None and name in found.star


def module_of_api(path: str) -> ApiName:
    """Return what is known of a module of the API.

    Parameters
    ----------
    path : str
        Its dotted path.
    """
    there = frozenset(g for g in BOTH if face(path, g) is not None)
    return ApiName(path, Role.MODULE, there)


def member_of_api(module: str, name: str) -> ApiName:
    """Return what is known of a name that is asked of a module of the API.

    Parameters
    ----------
    module : str
        Dotted path of the module.
    name : str
        Name without dots.
    """
    there = {g for g in BOTH if has(module, name, g)}
    if name in OLD_FUNCTIONS and module.endswith(OLD_FUNCTIONS[name][0]):
        there.add(0)
    role = Role.MODULE if module_of_api(f"{module}.{name}").generations else Role.FUNCTION
    shown = f"{module}.{name}" if role is Role.MODULE or not there else name
    return ApiName(shown, role, frozenset(there))


def starred_of_api(modules: list[str], name: str) -> ApiName:
    """Return what is known of a name that a star of the API brings.

    Parameters
    ----------
    modules : list of str
        Dotted names of the modules whose stars the script takes.
    name : str
        Name without dots, used where no statement binds it.
    """
    there = {g for g in BOTH if any(brings(module, name, g) for module in modules)}
    if name in OLD_FUNCTIONS and not there:
        there.add(0)
    is_function = name in FUNCTIONS or name in NEW_FUNCTIONS or name in OLD_FUNCTIONS
    return ApiName(name, Role.FUNCTION if is_function else Role.STAR, frozenset(there))


def attribute_of_api(name: str) -> ApiName | None:
    """Return what is known of an attribute of a Robotarium; None of one that all have, or none.

    Parameters
    ----------
    name : str
        What stands behind the dot.
    """
    if name in ATTRIBUTES:
        return ApiName(name, Role.ATTRIBUTE, frozenset({1}))
    if name in NEW_ATTRIBUTES or name in ATTRIBUTES.values():
        return ApiName(name, Role.ATTRIBUTE, frozenset({2}))
    if name in OLD_ATTRIBUTES:
        return ApiName(name, Role.ATTRIBUTE, frozenset({0}))
    return None


def constructor_argument(name: str) -> ApiName | None:
    """Return what is known of a named argument of Robotarium; None of one that both have.

    Parameters
    ----------
    name : str
        What stands before the equals sign.
    """
    generations = {1, 2} if name in CONSTRUCTOR else set()
    if name in NEW_ARGUMENTS:
        generations = {2}
    elif name in OLD_ARGUMENTS:
        generations = {0}
    if not generations or generations == BOTH:
        return None
    return ApiName(name, Role.ARGUMENT, frozenset(generations), of="Robotarium")
