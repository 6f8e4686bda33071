"""A script and the modules beside it, with what is known of their names and expressions.

What is known is found by the :mod:`interpretation <rps_compat.scripts.interpretation>`, in several
rounds, each of which goes through all that runs. What a round finds of functions, classes and
attributes the next one knows from its beginning.
"""

from __future__ import annotations

import ast
from collections import defaultdict
from dataclasses import dataclass, field

from rps_compat.errors import ScriptError
from rps_compat.scripts.generation_names import ROBOTARIUM
from rps_compat.scripts.libraries import SIMULATOR
from rps_compat.scripts.source import Script, read_script
from rps_compat.scripts.values import (
    ANYTHING,
    UNKNOWN,
    Class,
    Function,
    Instance,
    Origin,
    Scope,
    Value,
    Values,
    bases_of,
    origins,
)

#: Modules beside a script that are read at most.
_MODULES = 60
#: Our own packages: they are not what a script consists of.
_OURS = frozenset({SIMULATOR, "rps_compat", "posflock_robotarium", "barrier_certificates"})
#: What a Robotarium is, and its classes.
ROBOTS = frozenset(
    {f"{ROBOTARIUM}", "rps.robotarium_abc.RobotariumABC", "rps.robotarium_abc.ARobotarium"}
)


@dataclass(eq=False, repr=False)
class Module:
    """The script, or a module beside it.

    Attributes
    ----------
    name : str
        Dotted name; "" is the script.
    script : Script
        Its source, as read.
    is_package : bool
        Whether it is an ``__init__.py``.
    stars : list of str
        Modules whose names it takes by ``from … import *``, in order.
    scope : Scope
        What its names stand for.
    """

    name: str
    script: Script
    is_package: bool = False
    stars: list[str] = field(default_factory=list)
    scope: Scope = field(default_factory=Scope)

    @property
    def package(self) -> str:
        """The package that relative imports start from."""
        return self.name if self.is_package else self.name.rpartition(".")[0]


class Program:
    """A script with the modules beside it that it imports, and what is known of them.

    Of a new one nothing is known: `rps_compat.scripts.interpretation.interpret` finds it out.

    Parameters
    ----------
    script : Script
        The main file.
    """

    def __init__(self, script: Script) -> None:
        self.script = script
        self.main = Module("", script)
        self._modules: dict[str, Module | None] = {"": self.main}
        #: What each expression stands for, by node.
        self.values: dict[ast.AST, Values] = {}
        #: Names that a star brought, by node → the module of the star.
        self.starred: dict[ast.AST, str] = {}
        #: Attributes given to what nobody knows, by name.
        self.loose: dict[str, Values] = {}
        self._functions: dict[ast.AST, Function] = {}
        self._classes: dict[ast.AST, Class] = {}
        self._by_attribute: dict[str, Values] = {}
        #: Whether this round brought anything new.
        self.grown = False
        #: What something stands for of which nothing is known: nothing yet, later anything.
        self.absent: Values = frozenset()
        #: Names of the modules that have run in this round.
        self.begun: set[str] = set()

    def begin_round(self) -> None:
        """Forget what expressions stand for; what was found of definitions and attributes stays."""
        self.grown = False
        self.values, self.starred = defaultdict(frozenset), {}
        self._by_attribute = self._attributes_by_name()
        self.begun = set()

    def begin(self, module: Module) -> None:
        """Take note that a module runs in this round: it binds its names anew.

        Parameters
        ----------
        module : Module
            The script, or one beside it.
        """
        self.begun.add(module.name)
        module.scope.names, module.stars = {}, []

    @property
    def modules(self) -> list[Module]:
        """The script and every module beside it that it imports, the script first."""
        return [module for module in self._modules.values() if module is not None]

    def module(self, name: str) -> Module | None:
        """Return the module that lies beside the script, or None.

        Parameters
        ----------
        name : str
            Its dotted name.
        """
        if name not in self._modules:
            self._modules[name] = self._read(name)
        return self._modules[name]

    def _read(self, name: str) -> Module | None:
        parts = name.split(".")
        if parts[0] in _OURS or not all(parts) or len(self._modules) > _MODULES:
            return None
        place = self.script.path.parent.joinpath(*parts)
        for path, is_package in ((place / "__init__.py", True), (place.with_suffix(".py"), False)):
            if path.is_file() and path != self.script.path:
                try:
                    return Module(name, read_script(path), is_package)
                except ScriptError:
                    return None
        return None

    def function(
        self, node: ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda, scope: Scope
    ) -> Function:
        """Return the one function of a definition.

        Parameters
        ----------
        node : ast.FunctionDef, ast.AsyncFunctionDef or ast.Lambda
            Where it is defined.
        scope : Scope
            Where it is defined.
        """
        if node not in self._functions:
            self._functions[node] = Function(node, scope)
        return self._functions[node]

    def class_(self, node: ast.ClassDef) -> Class:
        """Return the one class of a definition.

        Parameters
        ----------
        node : ast.ClassDef
            Where it is defined.
        """
        if node not in self._classes:
            self._classes[node] = Class(node)
        return self._classes[node]

    def add(self, table: dict[str, Values], name: str, values: Values) -> None:
        """Add to what a name of a table stands for.

        Parameters
        ----------
        table : dict
            From name to what it stands for.
        name : str
            Key of the table.
        values : frozenset
            What is added.
        """
        before = table.get(name, frozenset())
        if not values <= before or name not in table:
            table[name] = before | values
            self.grown = True

    def _attributes_by_name(self) -> dict[str, Values]:
        found: dict[str, Values] = dict(self.loose)
        for of in self._classes.values():
            for name, values in of.attributes.items():
                found[name] = found.get(name, frozenset()) | values
        return found

    def robots_called(self, name: str) -> Values:
        """Return what attributes of this name hold, wherever, if that is a Robotarium and no other.

        So ``team.robots.step()`` is a Robotarium's also where nobody knows what ``team`` is.

        Parameters
        ----------
        name : str
            What stands behind the dot.
        """
        found = self._by_attribute.get(name, frozenset())
        return found if found and self.is_robots(found) else frozenset()

    def instances_of(self, kinds: Values) -> Values:
        """Return what calling classes makes, as far as annotations matter.

        Parameters
        ----------
        kinds : frozenset
            The classes, and anything else.
        """
        made: set[Value] = {Instance(kind) for kind in kinds if isinstance(kind, Class)}
        made |= {Origin(f"{path}()") for path in origins(kinds) & ROBOTS}
        return frozenset(made)

    def is_robots(self, values: Values) -> bool:
        """Return whether all of these, and at least one, are a Robotarium.

        Parameters
        ----------
        values : frozenset
            What it may stand for.
        """
        return bool(values) and all(self._is_robot(value) for value in values)

    def _is_robot(self, value: object) -> bool:
        if isinstance(value, Origin):
            return value.path.removesuffix("()") in ROBOTS and value.path.endswith("()")
        return isinstance(value, Instance) and bool(bases_of(value.of) & ROBOTS)

    def path_of(self, node: ast.AST) -> str:
        """Return the one dotted path that an expression stands for; "" if there is not just one.

        Parameters
        ----------
        node : ast.AST
            An expression of the script or of a module beside it.
        """
        values = self.values.get(node, ANYTHING)
        paths = origins(values)
        return paths.pop() if len(paths) == 1 and len(values - {UNKNOWN}) == 1 else ""
