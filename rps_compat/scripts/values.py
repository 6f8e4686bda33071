"""What a name or an expression of a script may stand for, as far as its source tells.

A value is an *origin*: the dotted path of something imported, ``numpy.mat``, with ``()`` where it
was called, ``rps.robotarium.Robotarium()``. Or it is a function, class, module or instance of the
script's own, or a container that holds values. A name may have several values: one from each
branch that binds it. The empty set is ``None``, which no attribute is asked of.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass, field
from typing import TypeAlias

#: Nothing is followed farther than this: ``x = x.T.copy()`` in a loop has no end.
FARTHEST = 8


@dataclass(frozen=True)
class Origin:
    """Something imported, or made by what is.

    Attributes
    ----------
    path : str
        Dotted path; ``()`` follows what is called.
    """

    path: str


@dataclass(eq=False, repr=False)
class Function:
    """A function or lambda of the script's own.

    Attributes
    ----------
    node : ast.FunctionDef, ast.AsyncFunctionDef or ast.Lambda
        Where it is defined.
    scope : Scope
        Where it is defined.
    owner : Class, optional
        Whose method it is.
    given : dict
        What its parameters were called with, by name.
    returns : frozenset
        What it returns.
    own : Scope, optional
        Names within it, once it was looked into.
    """

    node: ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda
    scope: Scope
    owner: Class | None = None
    given: dict[str, Values] = field(default_factory=dict)
    returns: Values = frozenset()
    own: Scope | None = None

    @property
    def decorators(self) -> set[str]:
        """Last parts of its decorators' names."""
        listed = getattr(self.node, "decorator_list", [])
        return {getattr(entry, "id", getattr(entry, "attr", "")) for entry in listed}


@dataclass(eq=False, repr=False)
class Class:
    """A class of the script's own.

    Attributes
    ----------
    node : ast.ClassDef
        Where it is defined.
    bases : frozenset
        What it derives from.
    attributes : dict
        What its attributes stand for, those of its instances included.
    """

    node: ast.ClassDef
    bases: Values = frozenset()
    attributes: dict[str, Values] = field(default_factory=dict)

    @property
    def is_dataclass(self) -> bool:
        """Whether its constructor is made from its annotated fields."""
        return any("dataclass" in ast.unparse(entry) for entry in self.node.decorator_list)


@dataclass(frozen=True)
class Instance:
    """An object of a class of the script's own.

    Attributes
    ----------
    of : Class
        Whose attributes and methods it has.
    """

    of: Class


@dataclass(frozen=True)
class Super:
    """What ``super()`` is within a class of the script's own.

    Attributes
    ----------
    of : Class
        The class in which it stands.
    """

    of: Class


@dataclass(frozen=True)
class Method:
    """A method of the script's own, asked of an object or class.

    Attributes
    ----------
    function : Function
        What a call of it runs.
    owner : Instance or Class
        What it was asked of.
    """

    function: Function
    owner: Instance | Class


@dataclass(frozen=True)
class OwnModule:
    """A module that lies beside the script.

    Attributes
    ----------
    name : str
        Its dotted name.
    """

    name: str


@dataclass(frozen=True)
class Held:
    """A container, by what it holds.

    Attributes
    ----------
    values : frozenset
        What it holds.
    """

    values: Values


@dataclass(frozen=True)
class Nothing:
    """Two marks: something that the source does not tell, and a name not bound (yet).

    Attributes
    ----------
    mark : str
        Which of the two.
    """

    mark: str


UNKNOWN, UNBOUND = Nothing("unknown"), Nothing("unbound")
Value: TypeAlias = (
    Origin | Function | Class | Instance | Super | Method | OwnModule | Held | Nothing
)
Values: TypeAlias = frozenset[Value]
NONE: Values = frozenset()
ANYTHING: Values = frozenset({UNKNOWN})


@dataclass(eq=False, repr=False)
class Scope:
    """Names of a module, class, function or comprehension.

    Attributes
    ----------
    parent : Scope, optional
        Where its free names are looked up.
    local : frozenset of str, optional
        Names that are its own; None where every name bound here is.
    names : dict
        What each name stands for at the moment.
    ever : dict
        What it has ever stood for: what functions called later see.
    elsewhere : dict
        Names declared ``global`` or ``nonlocal`` → the scope they belong to.
    shared : set of str
        Its names that functions declare so: they stand for whatever they ever did.
    live : bool
        Whether its free names stand for what they do at the moment: of classes, comprehensions.
    is_class : bool
        Whether it is a class.
    """

    parent: Scope | None = None
    local: frozenset[str] | None = None
    names: dict[str, Values] = field(default_factory=dict)
    ever: dict[str, Values] = field(default_factory=dict)
    elsewhere: dict[str, Scope] = field(default_factory=dict)
    shared: set[str] = field(default_factory=set)
    live: bool = False
    is_class: bool = False


def origins(values: Values) -> set[str]:
    """Return the paths of all origins among some values.

    Parameters
    ----------
    values : frozenset
        What it may stand for.
    """
    return {value.path for value in values if isinstance(value, Origin)}


def held(values: Values) -> Values:
    """Return a container, of no more depth than scripts have.

    Parameters
    ----------
    values : frozenset
        What it holds.
    """
    flat = frozenset(
        UNKNOWN
        if isinstance(value, Held) and any(isinstance(v, Held) for v in value.values)
        else value
        for value in values
    )
    return frozenset({Held(flat)})


def elements(values: Values) -> Values:
    """Return what iterating over something, or an index of it, gives.

    Parameters
    ----------
    values : frozenset
        What it may stand for.
    """
    out: Values = frozenset()
    for value in values:
        out |= value.values if isinstance(value, Held) else ANYTHING
    return out


def bases_of(of: Class, depth: int = 0) -> set[str]:
    """Return the paths of all that a class derives from, through classes of the script's own.

    Parameters
    ----------
    of : Class
        One of the script's own.
    depth : int
        How many classes deep this call is; circles end somewhere.
    """
    found: set[str] = set()
    for base in of.bases:
        if isinstance(base, Origin):
            found.add(base.path)
        elif isinstance(base, Class) and depth < FARTHEST:
            found |= bases_of(base, depth + 1)
    return found
