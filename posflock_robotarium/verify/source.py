"""A script as the checks see it: its tree, its names, and the loops that drive the robots."""

from __future__ import annotations

import ast
from collections.abc import Set
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from posflock_robotarium.verify.constants import Names, constants_of
from rps_compat.scripts import import_graph
from rps_compat.scripts.interpretation import interpret
from rps_compat.scripts.program import Program
from rps_compat.scripts.source import Script
from rps_compat.scripts.uses import Use, constructor_arguments, uses_in


@dataclass
class Source:
    """A script that parses, with what every check needs of it.

    Attributes
    ----------
    script : Script
        As it was read.
    generation : int
        Of the testbed's API that it is to run on, 1 or 2.
    search : tuple of Path
        Where local modules may lie, besides its own folder.
    names : dict
        Names that are bound once to a value that can be read off, and the values.
    """

    script: Script
    generation: int = 2
    search: tuple[Path, ...] = ()
    names: Names = field(init=False)

    def __post_init__(self) -> None:
        self.names = constants_of(self.tree)

    @property
    def path(self) -> Path:
        """Where it lies."""
        return self.script.path

    @property
    def tree(self) -> ast.Module:
        """Its syntax tree."""
        return self.script.tree

    @cached_property
    def program(self) -> Program:
        """What its names and expressions stand for."""
        return interpret(self.script)

    @cached_property
    def uses(self) -> list[Use]:
        """Names in it, and in the modules beside it, that not every testbed has."""
        return uses_in(self.program)

    @cached_property
    def trace(self) -> import_graph.Trace:
        """Everything it imports."""
        return import_graph.trace(self.path, self.search)

    def called(self, call: ast.Call) -> str:
        """Return the dotted path of what is called, as ``numpy.load``; empty if unknown.

        Python's own functions go by their bare names.

        Parameters
        ----------
        call : ast.Call
            One of the script's calls.
        """
        return self.program.path_of(call.func).removeprefix("builtins.")

    def constructs(self, call: ast.Call) -> bool:
        """Return whether a call is one of Robotarium's constructor.

        Parameters
        ----------
        call : ast.Call
            One of the script's calls.
        """
        return constructor_arguments(self.program, call) is not None

    @cached_property
    def calls(self) -> list[ast.Call]:
        """Every call, in the order of the text."""
        found = [node for node in ast.walk(self.tree) if isinstance(node, ast.Call)]
        return sorted(found, key=lambda call: (call.lineno, call.col_offset))

    @cached_property
    def owners(self) -> frozenset[str]:
        """Names before the dot of a call to one of the script's own methods."""
        return _owners(self.tree)

    @cached_property
    def stepping(self) -> frozenset[str]:
        """Names of functions of the script that step, directly or through another."""
        functions = [node for node in ast.walk(self.tree) if isinstance(node, ast.FunctionDef)]
        stepping: frozenset[str] = frozenset()
        while True:
            found = frozenset(f.name for f in functions if _steps(f, stepping, self.owners))
            if found == stepping:
                return stepping
            stepping = found

    @cached_property
    def stepping_loops(self) -> list[ast.For | ast.While]:
        """Outermost loops that drive the robots: that step, or call a function that does."""
        found: list[ast.For | ast.While] = []

        def look(node: ast.AST) -> None:
            for child in ast.iter_child_nodes(node):
                if isinstance(child, (ast.For, ast.While)) and _steps(
                    child, self.stepping, self.owners
                ):
                    found.append(child)
                else:
                    look(child)

        look(self.tree)
        return found

    @cached_property
    def counts_its_steps(self) -> bool:
        """Whether every loop that drives the robots ends after a number of steps."""
        loops = self.stepping_loops
        return bool(loops) and all(_is_counted(loop, self) for loop in loops)


def _is_counted(loop: ast.For | ast.While, source: Source) -> bool:
    """Whether a loop counts its steps: over a range, or in a variable that its test compares."""
    if isinstance(loop, ast.For):
        endless = ("itertools.count", "itertools.cycle", "itertools.repeat", "iter")
        return not any(
            isinstance(node, ast.Call) and source.called(node) in endless
            for node in ast.walk(loop.iter)
        )
    counted = {
        node.target.id
        for node in ast.walk(loop)
        if isinstance(node, ast.AugAssign) and isinstance(node.target, ast.Name)
    }
    return isinstance(loop.test, ast.Compare) and any(
        isinstance(node, ast.Name) and node.id in counted for node in ast.walk(loop.test)
    )


def _owners(tree: ast.Module) -> frozenset[str]:
    """Return ``self``, the script's classes, and the names that an object of one is bound to."""
    classes = {node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef)}
    bound: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            value, targets = node.value, node.targets
        elif isinstance(node, ast.withitem) and node.optional_vars is not None:
            value, targets = node.context_expr, [node.optional_vars]
        else:
            continue
        if isinstance(value, ast.Call) and getattr(value.func, "id", "") in classes:
            bound |= {target.id for target in targets if isinstance(target, ast.Name)}
    return frozenset({"self"} | classes | bound)


def _steps(node: ast.AST, stepping: Set[str], known: frozenset[str]) -> bool:
    return any(
        is_call_to(inner, stepping, known)
        or (
            isinstance(inner, ast.Call)
            and isinstance(inner.func, ast.Attribute)
            and inner.func.attr == "step"
            and not inner.args
            and not inner.keywords
        )
        for inner in ast.walk(node)
    )


def is_call_to(node: ast.AST, names: Set[str], known: frozenset[str]) -> bool:
    """Return whether a node calls one of some functions, or such a method of a known owner.

    Parameters
    ----------
    node : ast.AST
        Any node of the script.
    names : set of str
        Names of the functions and methods.
    known : frozenset of str
        Names of the owners.
    """
    if not isinstance(node, ast.Call):
        return False
    func = node.func
    if isinstance(func, ast.Name):
        return func.id in names
    if not isinstance(func, ast.Attribute) or func.attr not in names:
        return False
    owner = func.value.func if isinstance(func.value, ast.Call) else func.value
    return isinstance(owner, ast.Name) and owner.id in known
