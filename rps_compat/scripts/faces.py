"""What the modules of the API have, read off their source: importing them would cost a second.

:mod:`rps_compat.v1` and :mod:`rps_compat.v2` have every published name; nothing about them is
written down a second time.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from rps_compat.scripts.scopes import names_of, parameters_of

_HOME = Path(__file__).parents[1]
#: Modules of the API that have functions for scripts.
API_MODULES = tuple(
    f"rps.utilities.{name}"
    for name in (
        "barrier_certificates",
        "barrier_certificates2",
        "controllers",
        "graph",
        "misc",
        "sensors",
        "transformations",
    )
)


@dataclass(frozen=True)
class Face:
    """One module of the API in one generation.

    Attributes
    ----------
    names : frozenset of str
        Everything that it has.
    star : frozenset of str
        What ``from … import *`` brings.
    functions : dict
        Parameters of the functions that it defines, in order → whether they must be given.
    """

    names: frozenset[str]
    star: frozenset[str]
    functions: dict[str, dict[str, bool]]


@cache
def face(path: str, generation: int) -> Face | None:
    """Return what a module has that is imported as `path`, or None if there is no such module.

    Parameters
    ----------
    path : str
        Dotted path, beginning with ``rps``.
    generation : int
        1 or 2.
    """
    top, *parts = path.split(".")
    if top != "rps" or not all(part.isidentifier() for part in parts):
        return None
    place = _HOME.joinpath(f"v{generation}", *parts)
    file = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
    if not file.is_file():
        return None
    tree = ast.parse(file.read_bytes(), str(file))
    names = names_of(tree).local
    listed = _listed(tree)
    star = frozenset(n for n in names if not n.startswith("_")) if listed is None else listed
    functions = {
        node.name: _parameters(node) for node in tree.body if isinstance(node, ast.FunctionDef)
    }
    return Face(names | star, star, functions)


def parameters(function: str, generation: int) -> dict[str, bool]:
    """Return the parameters of a function of the API, in order → whether they must be given.

    Parameters
    ----------
    function : str
        Its bare name.
    generation : int
        1 or 2.

    Returns
    -------
    dict
        Empty where the generation has no such function.
    """
    for module in API_MODULES:
        found = face(module, generation)
        if found is not None and function in found.functions:
            return found.functions[function]
    return {}


def has(module: str, name: str, generation: int) -> bool:
    """Return whether a module of the API has a name, or a module of that name.

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
    if found is None:
        return False
    own = name.startswith("__") and hasattr(ast, name)  # what every module has, as __name__
    return own or name in found.names or face(f"{module}.{name}", generation) is not None


def _parameters(node: ast.FunctionDef) -> dict[str, bool]:
    of = node.args
    positional = [*of.posonlyargs, *of.args]
    optional = {p.arg for p in positional[len(positional) - len(of.defaults) :]}
    optional |= {p.arg for p, default in zip(of.kwonlyargs, of.kw_defaults, strict=True) if default}
    return {p.arg: p.arg not in optional for p in parameters_of(node)}


def _listed(tree: ast.Module) -> frozenset[str] | None:
    """Return ``__all__``, or None; it may unpack the keys of a table of the module."""
    assigned = {
        target.id: node.value
        for node in tree.body
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    listed = assigned.get("__all__")
    if not isinstance(listed, (ast.List, ast.Tuple)):
        return None
    names: set[str] = set()
    for entry in listed.elts:
        if isinstance(entry, ast.Starred) and isinstance(entry.value, ast.Name):
            names |= set(ast.literal_eval(assigned[entry.value.id]))
        else:
            names.add(ast.literal_eval(entry))
    return frozenset(names)
