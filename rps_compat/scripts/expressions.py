"""What an expression of a script stands for."""

from __future__ import annotations

import ast

from rps_compat.scripts.calls import called
from rps_compat.scripts.lookup import attribute, look_up
from rps_compat.scripts.program import Module, Program
from rps_compat.scripts.scopes import parameters_of
from rps_compat.scripts.values import (
    ANYTHING,
    NONE,
    Class,
    Function,
    Held,
    Scope,
    Values,
    elements,
    held,
)


class Evaluator(ast.NodeVisitor):
    """Evaluates the expressions of one module, in the scope that is current.

    Parameters
    ----------
    program : Program
        The script and the modules beside it.
    module : Module
        Whose expressions they are.
    """

    def __init__(self, program: Program, module: Module) -> None:
        self.program, self.module = program, module
        self.scope: Scope = module.scope
        #: Functions met and not yet looked into.
        self.waiting: list[Function] = []
        #: Classes around here.
        self.classes: list[Class] = []

    def value(self, node: ast.expr | None) -> Values:
        """Return what an expression stands for, and take note of it.

        Parameters
        ----------
        node : ast.expr or None
            The expression; None stands for nothing.
        """
        if node is None:
            return NONE
        found: Values = self.visit(node)
        self.program.values[node] |= found
        return found

    def generic_visit(self, node: ast.AST) -> Values:
        """Evaluate what an expression consists of; what it is itself nobody knows."""
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.expr):
                self.value(child)
            elif not isinstance(child, ast.stmt):
                self.generic_visit(child)
        return ANYTHING

    def visit_Constant(self, node: ast.Constant) -> Values:
        """Return nothing for ``None``, of which nothing is asked."""
        return NONE if node.value is None else ANYTHING

    def visit_Name(self, node: ast.Name) -> Values:
        """Look a name up."""
        found, star = look_up(self.program, self.module, self.scope, node.id)
        if star:
            self.program.starred[node] = star
        return found

    def visit_Attribute(self, node: ast.Attribute) -> Values:
        """Look an attribute up."""
        return attribute(self.program, self.value(node.value), node.attr)

    def visit_Call(self, node: ast.Call) -> Values:
        """Follow a call."""
        function = self.value(node.func)
        given = [self.value(argument) for argument in node.args]
        named = {k.arg: self.value(k.value) for k in node.keywords}
        self._filled(node, given)
        return called(self, function, node, given, named)

    def _filled(self, node: ast.Call, given: list[Values]) -> None:
        """Put what ``robots.append(r)`` adds into the container, where that has a name."""
        func = node.func
        if not isinstance(func, ast.Attribute) or not given:
            return
        if func.attr in ("append", "add", "appendleft", "insert"):
            self.put_into(func.value, given[-1])
        elif func.attr in ("extend", "update"):
            self.put_into(func.value, elements(given[-1]))

    def put_into(self, container: ast.expr, values: Values) -> None:
        """Let a container that has a name hold something as well.

        Parameters
        ----------
        container : ast.expr
            What ``append`` or an assignment to an item changes.
        values : frozenset
            What is put in.
        """
        before = self.program.values.get(container, frozenset())
        inside = [value.values for value in before if isinstance(value, Held)]
        if inside and isinstance(container, (ast.Name, ast.Attribute)):
            self.bind(container, held(values.union(*inside)))

    def bind(self, target: ast.expr, values: Values) -> None:
        """Let the target of an assignment stand for something: `Interpreter` does.

        Parameters
        ----------
        target : ast.expr
            A name, attribute or item, or several in a tuple or list.
        values : frozenset
            What it may stand for.

        Raises
        ------
        NotImplementedError
            Always, here.
        """
        raise NotImplementedError

    def visit_Lambda(self, node: ast.Lambda) -> Values:
        """Make a function; it is looked into later."""
        return frozenset({self.defined(node)})

    def defined(self, node: ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda) -> Function:
        """Make the function of a definition, with the defaults and annotations of its parameters.

        In a class it is a method; elsewhere it sees the names of the scope.

        Parameters
        ----------
        node : ast.FunctionDef, ast.AsyncFunctionDef or ast.Lambda
            Where it is defined.
        """
        function = self.program.function(node, self.scope)
        names = parameters_of(node)
        positional = [*node.args.posonlyargs, *node.args.args]
        if node.args.defaults:
            last = positional[-len(node.args.defaults) :]
            for parameter, default in zip(last, node.args.defaults, strict=True):
                self.program.add(function.given, parameter.arg, self.value(default))
        for parameter, maybe in zip(node.args.kwonlyargs, node.args.kw_defaults, strict=True):
            if maybe is not None:
                self.program.add(function.given, parameter.arg, self.value(maybe))
        for parameter in names:
            told = self.annotated(parameter.annotation)
            if told:
                self.program.add(function.given, parameter.arg, told)
        self.waiting.append(function)
        return function

    def annotated(self, annotation: ast.expr | None) -> Values:
        """Return what an annotation says a thing is; empty where that is no class that is known.

        Parameters
        ----------
        annotation : ast.expr or None
            The annotation; None where there is none.
        """
        if annotation is None:
            return NONE
        if isinstance(annotation, ast.Constant) and isinstance(annotation.value, str):
            try:
                inner = ast.parse(annotation.value, mode="eval").body
            except (SyntaxError, ValueError):
                return NONE
            return self.annotated(inner)
        if isinstance(annotation, ast.BinOp):
            return self.annotated(annotation.left) | self.annotated(annotation.right)
        if isinstance(annotation, ast.Subscript):
            return self.annotated(annotation.slice)
        kinds = (
            self.value(annotation) if isinstance(annotation, (ast.Name, ast.Attribute)) else NONE
        )
        return self.program.instances_of(kinds)

    def visit_NamedExpr(self, node: ast.NamedExpr) -> Values:
        """Bind and return."""
        found = self.value(node.value)
        self.bind(node.target, found)
        return found

    def visit_IfExp(self, node: ast.IfExp) -> Values:
        """Return one of both."""
        self.value(node.test)
        return self.value(node.body) | self.value(node.orelse)

    def visit_BoolOp(self, node: ast.BoolOp) -> Values:
        """Return one of all."""
        return NONE.union(*(self.value(part) for part in node.values))

    def visit_Await(self, node: ast.Await) -> Values:
        """Return what is waited for."""
        return self.value(node.value)

    def visit_Starred(self, node: ast.Starred) -> Values:
        """Return what is unpacked."""
        return elements(self.value(node.value))

    def visit_Subscript(self, node: ast.Subscript) -> Values:
        """Return an element of a container."""
        container = self.value(node.value)
        self.value(node.slice)
        if isinstance(node.slice, ast.Slice):
            return frozenset(v for v in container if isinstance(v, Held)) or ANYTHING
        return elements(container)

    def visit_BinOp(self, node: ast.BinOp) -> Values:
        """Join containers; nothing else is known."""
        both = self.value(node.left) | self.value(node.right)
        return frozenset(v for v in both if isinstance(v, Held)) or ANYTHING

    def _container(self, node: ast.List | ast.Tuple | ast.Set) -> Values:
        return held(NONE.union(*(self.value(entry) for entry in node.elts)))

    visit_List = visit_Tuple = visit_Set = _container

    def visit_Dict(self, node: ast.Dict) -> Values:
        """Return a container of its values."""
        for key in node.keys:
            self.value(key)
        return held(NONE.union(*(self.value(value) for value in node.values)))

    def _comprehension(self, node: ast.ListComp | ast.SetComp | ast.GeneratorExp) -> Values:
        return held(self._within(node.generators, [node.elt]))

    visit_ListComp = visit_SetComp = visit_GeneratorExp = _comprehension

    def visit_DictComp(self, node: ast.DictComp) -> Values:
        """Return a container of its values."""
        self._within(node.generators, [node.key])
        return held(self._within(node.generators, [node.value]))

    def _within(self, generators: list[ast.comprehension], made: list[ast.expr]) -> Values:
        """Evaluate `made` in the scope of a comprehension."""
        outer = self.scope
        self.scope = Scope(outer, live=True)
        for generator in generators:
            self.bind(generator.target, elements(self.value(generator.iter)))
            for test in generator.ifs:
                self.value(test)
        found = NONE.union(*(self.value(node) for node in made))
        self.scope = outer
        return found
