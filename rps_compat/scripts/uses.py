"""Every use of a name that not all generations of the API, or not all versions, have: the detector.

``lint`` and its rewriting, ``verify``, ``run``'s notes, ``bundle`` and ``rehearse`` all take their
findings from here. A name is the Robotarium's, numpy's or another library's only if what it is
bound to says so (:mod:`~rps_compat.scripts.interpretation`).
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

from rps_compat.scripts import api
from rps_compat.scripts.api import ApiName, Role
from rps_compat.scripts.changes import Change, Kind, change_of
from rps_compat.scripts.faces import parameters
from rps_compat.scripts.generation_names import OLD_COUNTED, ROBOTARIUM, UNMISTAKABLE, counterpart
from rps_compat.scripts.guards import Guards
from rps_compat.scripts.libraries import ABSENT, is_available
from rps_compat.scripts.lookup import member
from rps_compat.scripts.members import is_elsewhere, matter_of, matter_with
from rps_compat.scripts.program import ROBOTS, Module, Program
from rps_compat.scripts.syntax import newer_syntax, newer_than_the_testbeds
from rps_compat.scripts.values import (
    UNBOUND,
    UNKNOWN,
    Class,
    Function,
    Instance,
    Method,
    Origin,
    Values,
    bases_of,
)


@dataclass(frozen=True)
class Absent:
    """A library that the testbed has not.

    Attributes
    ----------
    name : str
        What a script imports.
    """

    name: str

    @property
    def what(self) -> str:
        """The matter in words."""
        return f"the testbed has no {self.name}"

    @property
    def advice(self) -> str:
        """What to do."""
        return ABSENT[self.name]


@dataclass(frozen=True)
class NewerSyntax:
    """Syntax that the testbed's Python does not read.

    Attributes
    ----------
    name : str
        What it is, in words.
    """

    name: str

    @property
    def what(self) -> str:
        """The matter in words."""
        return newer_than_the_testbeds(self.name)


Entry: TypeAlias = ApiName | Change | Absent | NewerSyntax
#: What to do about names and syntax of a newer Python.
OLDER_WAY = "the testbed runs Python 3.10; write it the older way"


@dataclass(frozen=True)
class Use:
    """One use of such a name.

    Attributes
    ----------
    module : Module
        In which it stands.
    node : ast.AST
        The name, attribute, call or import.
    line, column : int
        Where; lines count from 1, columns from 0 in bytes of UTF-8.
    entry : ApiName, Change, Absent or NewerSyntax
        What is the matter.
    ready : bool
        Whether the script is ready for its absence, or never gets there on the testbed.
    follows : bool
        Whether the import that brought the name is told of already.
    """

    module: Module
    node: ast.AST
    line: int
    column: int
    entry: Entry
    ready: bool = False
    follows: bool = False

    def stops(self, generation: int) -> bool:
        """Return whether the testbed stops here.

        Parameters
        ----------
        generation : int
            Of the API: 1 or 2.
        """
        return not self.ready and self.matters(generation)

    def matters(self, generation: int) -> bool:
        """Return whether a generation, or the testbed's version of a library, has it not.

        Parameters
        ----------
        generation : int
            Of the API: 1 or 2.
        """
        if isinstance(self.entry, ApiName):
            return self.entry.stops(generation)
        return not (isinstance(self.entry, Change) and self.entry.kind is Kind.LATER)

    @property
    def what(self) -> str:
        """The matter in words."""
        return self.entry.what

    def remedy(self, generation: int) -> str:
        """Return what to do about it, in words.

        Parameters
        ----------
        generation : int
            Of the API: 1 or 2.
        """
        if isinstance(self.entry, ApiName):
            return self.entry.remedy(generation)
        if isinstance(self.entry, Absent):
            return self.entry.advice
        if isinstance(self.entry, NewerSyntax):
            return OLDER_WAY
        return self.entry.remedy


def uses_in(program: Program) -> list[Use]:
    """List all uses in a script and the modules beside it, by file and line.

    Parameters
    ----------
    program : Program
        The script and the modules beside it.
    """
    found = [use for module in program.modules for use in _Detector(program, module).uses()]
    if any(isinstance(u.entry, ApiName) and u.entry.generations == {0} for u in found):
        found += [u for module in program.modules for u in _Detector(program, module).counted()]
    unique = {(use.module.name, use.line, use.column, use.entry): use for use in reversed(found)}
    return sorted(unique.values(), key=lambda use: (use.module.name, use.line, use.column))


class _Detector:
    """Finds the uses in one module."""

    def __init__(self, program: Program, module: Module) -> None:
        self._program, self._module = program, module
        self._tree = module.script.tree
        self._guards = Guards(self._tree)

    def uses(self) -> Iterator[Use]:
        for line, what in newer_syntax(self._module.script.text, self._tree):
            yield Use(self._module, self._tree, line, 0, NewerSyntax(what))
        for node in ast.walk(self._tree):
            if isinstance(node, ast.Import):
                yield from self._import(node)
            elif isinstance(node, ast.ImportFrom):
                yield from self._import_from(node)
            elif isinstance(node, ast.Name):
                yield from self._name(node)
            elif isinstance(node, ast.Attribute):
                yield from self._attribute(node)
            elif isinstance(node, ast.Call):
                yield from self._call(node)

    def _use(self, node: ast.expr | ast.alias, entry: Entry, follows: bool = False) -> Use:
        line, column = node.lineno, node.col_offset
        if isinstance(node, ast.Attribute):
            line = node.end_lineno or line
            column = (node.end_col_offset or 0) - len(node.attr.encode())
        return Use(self._module, node, line, column, entry, self._is_ready(node, entry), follows)

    def _is_ready(self, node: ast.AST, entry: Entry) -> bool:
        if node in self._guards.unreached or node in self._guards.ready:
            return True
        name = entry.name
        others = {name, *(counterpart(name, generation) for generation in (1, 2))}
        if isinstance(entry, Change):
            others.add(entry.code.strip("{}().-"))
        return bool(others & self._guards.asked)

    # --- Imports ---------------------------------------------------------------------------

    def _import(self, node: ast.Import) -> Iterator[Use]:
        for alias in node.names:
            yield from self._module_use(alias, alias.name)

    def _module_use(self, node: ast.alias, path: str) -> Iterator[Use]:
        top = path.partition(".")[0]
        if self._program.module(top) is not None:
            return
        if top == "rps":
            entry = api.module_of_api(path)
            if entry.generations != api.BOTH:
                yield self._use(node, entry)
            return
        parts = path.split(".")
        for k in range(1, len(parts) + 1):
            change = change_of(".".join(parts[:k]))
            if change is not None:
                yield self._use(node, change)
                return
        if top in ABSENT and not is_available(top):
            yield self._use(node, Absent(top))

    def _import_from(self, node: ast.ImportFrom) -> Iterator[Use]:
        path = node.module or ""
        if node.level or self._program.module(path) is not None:
            return
        found = list(self._module_use(node.names[0], path))
        yield from found
        if any(use.matters(generation) for use in found for generation in api.BOTH):
            return
        for alias in node.names:
            if alias.name == "*":
                continue
            entry = matter_of(path, alias.name)
            if entry is not None:
                yield self._use(alias, entry)

    # --- Names and attributes ----------------------------------------------------------------

    def _name(self, node: ast.Name) -> Iterator[Use]:
        if not isinstance(node.ctx, ast.Load):
            return
        star = self._program.starred.get(node)
        if star is not None and star.partition(".")[0] == "rps":
            stars = [s for s in self._module.stars if s.partition(".")[0] == "rps"]
            entry = api.starred_of_api(stars, node.id)
            if entry.generations and not entry.generations >= api.BOTH:
                yield self._use(node, entry)
            return
        for path in self._one_origin(self._program.values.get(node, frozenset())):
            change = change_of(path)
            if star is not None or path == f"builtins.{node.id}":
                if change is not None:
                    yield self._use(node, change)
            elif path in self._imported.get(node.id, ()):
                module, _, name = path.rpartition(".")
                entry_of_import = matter_of(module, name)
                if entry_of_import is not None:
                    yield self._use(node, entry_of_import, follows=True)

    @cached_property
    def _imported(self) -> dict[str, set[str]]:
        """Names that ``from … import`` binds under their own name, and what they stand for."""
        found: dict[str, set[str]] = {}
        for node in ast.walk(self._tree):
            if isinstance(node, ast.ImportFrom) and not node.level:
                for alias in node.names:
                    if alias.asname in (None, alias.name):
                        found.setdefault(alias.name, set()).add(f"{node.module}.{alias.name}")
        return found

    def _one_origin(self, values: Values) -> list[str]:
        """Return the path of `values` if they are one origin and nothing else."""
        known = [value for value in values if value is not UNBOUND]
        return [v.path for v in known if isinstance(v, Origin)] if len(known) == 1 else []

    def _attribute(self, node: ast.Attribute) -> Iterator[Use]:
        owners = self._program.values.get(node.value, frozenset()) - {UNBOUND}
        entries = [matter_with(owner, node.attr) for owner in owners if not is_elsewhere(owner)]
        found = {entry for entry in entries if entry is not None}
        if found and None not in entries:
            for entry in found:
                yield self._use(node, entry)
        elif (
            node.attr in UNMISTAKABLE
            and node.attr not in self._own_names
            and all(owner is UNKNOWN for owner in owners)
        ):
            known = api.attribute_of_api(node.attr)
            assert known is not None
            yield self._use(node, known)

    @cached_property
    def _own_names(self) -> set[str]:
        trees = [module.script.tree for module in self._program.modules]
        return {
            node.name
            for tree in trees
            for node in ast.walk(tree)
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
        }

    # --- Calls -----------------------------------------------------------------------------

    def _call(self, node: ast.Call) -> Iterator[Use]:
        positional = constructor_arguments(self._program, node)
        if positional is not None:
            if any(not isinstance(argument, ast.Starred) for argument in positional):
                by_position = ApiName("", Role.POSITIONAL, frozenset({0, 1}), of="Robotarium")
                yield self._use(node, by_position)
            for keyword in node.keywords:
                known = api.constructor_argument(keyword.arg or "")
                if known is not None:
                    yield self._use(keyword.value, known)
            return
        name = api_function(self._program, node)
        taken = {g: parameters(name, g) for g in api.BOTH if name and parameters(name, g)}
        for keyword in node.keywords if taken else ():
            argument = keyword.arg
            if name in OLD_COUNTED and argument == "number_of_agents":
                old = ApiName(argument, Role.ARGUMENT, frozenset({0}), of=name)
                yield self._use(keyword.value, old)
            elif argument is not None:
                there = frozenset(g for g, has in taken.items() if argument in has)
                if there and there != frozenset(taken):
                    yield self._use(keyword.value, ApiName(argument, Role.ARGUMENT, there, of=name))
        plain = [a for a in node.args if not isinstance(a, ast.Starred)]
        fits = frozenset(g for g, has in taken.items() if len(plain) <= len(has))
        if fits and fits != frozenset(taken):
            first_too_many = plain[min(len(has) for has in taken.values())]
            longest = max(taken.values(), key=len)
            argument = list(longest)[len(plain) - 1]
            yield self._use(first_too_many, ApiName(argument, Role.ARGUMENT, fits, of=name))

    def counted(self) -> Iterator[Use]:
        """In a script of generation 0, find the numbers of robots that certificates are given."""
        for node in ast.walk(self._tree):
            if isinstance(node, ast.Call) and node.args:
                name = api_function(self._program, node)
                if name in OLD_COUNTED:
                    old = ApiName("number_of_agents", Role.ARGUMENT, frozenset({0}), of=name)
                    yield self._use(node.args[0], old)


def constructor_arguments(program: Program, node: ast.Call) -> list[ast.expr] | None:
    """Return what a call of Robotarium's constructor is given by position; None of other calls.

    Parameters
    ----------
    program : Program
        The script and the modules beside it.
    node : ast.Call
        Any call of the script.
    """
    for value in program.values.get(node.func, frozenset()):
        if isinstance(value, Origin):
            base, _, start = value.path.rpartition(".")
            if value.path in ROBOTS:
                return node.args
            if start == "__init__" and base.removesuffix("()") in ROBOTS:
                return node.args if base.endswith("()") else node.args[1:]
        elif isinstance(value, Class) and bases_of(value) & ROBOTS:
            starts = member(value, "__init__", Instance(value))
            if not any(isinstance(start, (Function, Method)) for start in starts):
                return node.args
    return None


def api_function(program: Program, node: ast.Call) -> str:
    """Return the name of the API's function that is called; "" if it is none.

    Parameters
    ----------
    program : Program
        The script and the modules beside it.
    node : ast.Call
        Any call of the script.
    """
    path = program.path_of(node.func)
    if not path.startswith("rps.") or "(" in path or path == ROBOTARIUM:
        return ""
    return path.rpartition(".")[2]
