"""What each name of a script is bound to, statement by statement."""

from __future__ import annotations

import ast
from collections.abc import Sequence

from rps_compat.scripts.assignments import Binder
from rps_compat.scripts.exports import canonical
from rps_compat.scripts.lookup import module_attribute
from rps_compat.scripts.program import Module, Program
from rps_compat.scripts.scopes import names_of, parameters_of
from rps_compat.scripts.values import (
    ANYTHING,
    NONE,
    UNBOUND,
    Function,
    Instance,
    Origin,
    OwnModule,
    Scope,
    Values,
    elements,
    held,
)


class Interpreter(Binder):
    """Walks through one module and the functions that it defines.

    Parameters
    ----------
    program : Program
        The script and the modules beside it.
    module : Module
        The one to walk through.
    """

    def __init__(self, program: Program, module: Module) -> None:
        super().__init__(program, module)
        self._function: Function | None = None

    def run(self) -> None:
        """Walk through the module, then through its functions."""
        self.program.begin(self.module)
        self._walk(self.module.script.tree.body)
        while self.waiting:
            self._look_into(self.waiting.pop(0))

    def _walk(self, body: Sequence[ast.stmt]) -> None:
        for statement in body:
            try:
                self.visit(statement)
            except RecursionError:  # an expression deeper than anybody writes
                continue

    def _look_into(self, function: Function) -> None:
        node = function.node
        names = names_of(node)
        scope = function.own
        if scope is None:
            scope = function.own = Scope(function.scope, names.local)
            scope.elsewhere = dict.fromkeys(names.taken_global, self.module.scope)
            for name in names.taken_nonlocal:
                scope.elsewhere[name] = _scope_of(function.scope, name)
            for name, owner in scope.elsewhere.items():
                owner.shared.add(name)
        scope.names = {p.arg: self._parameter(function, p) for p in parameters_of(node)}
        for name, values in scope.names.items():
            self.program.add(scope.ever, name, values)
        outer = self.scope, self._function, self.classes
        self.scope, self._function = scope, function
        self.classes = [function.owner] if function.owner else []
        if isinstance(node, ast.Lambda):
            self._returned(self.value(node.body))
        else:
            self._walk(node.body)
        self.scope, self._function, self.classes = outer

    def _parameter(self, function: Function, parameter: ast.arg) -> Values:
        owner, first = function.owner, parameters_of(function.node)[:1]
        if owner is not None and first == [parameter]:
            if "classmethod" in function.decorators:
                return frozenset({owner})
            if "staticmethod" not in function.decorators:
                return frozenset({Instance(owner)})
        return function.given.get(parameter.arg) or self.program.absent

    def _returned(self, values: Values) -> None:
        function = self._function
        if function is not None and not values <= function.returns:
            function.returns |= values
            self.program.grown = True

    # --- Branches --------------------------------------------------------------------------

    def _joined(self, bodies: Sequence[Sequence[ast.stmt]]) -> None:
        """Walk through each of `bodies` from here; go on with what any of them leaves."""
        before, ends = self.scope.names, []
        for body in bodies:
            self.scope.names = dict(before)
            self._walk(body)
            if not _leaves(body):
                ends.append(self.scope.names)
        self.scope.names = _joined(ends) if ends else dict(before)

    def visit_If(self, node: ast.If) -> None:
        """Go both ways."""
        self.value(node.test)
        self._joined([node.body, node.orelse])

    def visit_While(self, node: ast.While) -> None:
        """Go through the body twice: what its end binds is there when it begins again."""
        for _ in range(2):
            self.value(node.test)
            self._joined([node.body, []])
        self._walk(node.orelse)

    def visit_For(self, node: ast.For | ast.AsyncFor) -> None:
        """Go through the body twice, as for ``while``."""
        each = elements(self.value(node.iter))
        for _ in range(2):
            self.bind(node.target, each)
            self._joined([node.body, []])
        self._walk(node.orelse)

    visit_AsyncFor = visit_For

    def visit_Try(self, node: ast.Try) -> None:
        """Begin handlers with what the body may have bound before it failed."""
        before = dict(self.scope.names)
        self._walk(node.body)
        middle = _joined([before, self.scope.names])
        self._walk(node.orelse)
        ends = [] if _leaves([*node.body, *node.orelse]) else [self.scope.names]
        for handler in node.handlers:
            self.scope.names = dict(middle)
            self.value(handler.type)
            if handler.name:
                self.bind_name(handler.name, ANYTHING)
            self._walk(handler.body)
            if handler.name:
                self.scope.names[handler.name] = frozenset({UNBOUND})
            if not _leaves(handler.body):
                ends.append(self.scope.names)
        self.scope.names = _joined(ends) if ends else middle
        self._walk(node.finalbody)

    visit_TryStar = visit_Try

    def visit_With(self, node: ast.With | ast.AsyncWith) -> None:
        """Take what a context manager gives for the manager itself."""
        for item in node.items:
            values = self.value(item.context_expr)
            if item.optional_vars is not None:
                self.bind(item.optional_vars, values)
        self._walk(node.body)

    visit_AsyncWith = visit_With

    def visit_Match(self, node: ast.Match) -> None:
        """Go through each case, or none."""
        subject = self.value(node.subject)
        before, ends = self.scope.names, [dict(self.scope.names)]
        for case in node.cases:
            self.scope.names = dict(before)
            self._captured(case.pattern, subject)
            self.value(case.guard)
            self._walk(case.body)
            if not _leaves(case.body):
                ends.append(self.scope.names)
        self.scope.names = _joined(ends)

    def _captured(self, pattern: ast.AST, subject: Values) -> None:
        if isinstance(pattern, ast.MatchAs):
            if pattern.pattern is not None:
                self._captured(pattern.pattern, subject)
            if pattern.name:
                self.bind_name(pattern.name, subject)
            return
        name = getattr(pattern, "name", None) or getattr(pattern, "rest", None)
        if isinstance(name, str):
            self.bind_name(name, ANYTHING)
        for part in ast.iter_child_nodes(pattern):
            if isinstance(part, ast.expr):
                self.value(part)
            else:
                self._captured(part, elements(subject))

    # --- Definitions and imports -----------------------------------------------------------

    def visit_FunctionDef(self, node: ast.FunctionDef | ast.AsyncFunctionDef) -> None:
        """Bind the function; its body is looked into later."""
        for decorator in node.decorator_list:
            self.value(decorator)
        scope = self.scope
        owner = self.classes[-1] if scope.is_class and self.classes else None
        while scope.live and scope.parent is not None:
            scope = scope.parent
        function = self.program.function(node, scope)
        function.owner = owner
        self.defined(node)
        self.bind_name(node.name, frozenset({function}))

    visit_AsyncFunctionDef = visit_FunctionDef

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        """Bind the class, whose body runs at once in a scope of its own."""
        for entry in (*node.decorator_list, *(k.value for k in node.keywords)):
            self.value(entry)
        made = self.program.class_(node)
        bases = NONE.union(*(self.value(base) for base in node.bases))
        if not bases <= made.bases:
            made.bases |= bases
            self.program.grown = True
        outer = self.scope
        self.scope = Scope(outer, live=True, is_class=True)
        self.classes.append(made)
        self._walk(node.body)
        for name, values in self.scope.names.items():
            self.program.add(made.attributes, name, values)
        self.scope = outer
        self.classes.pop()
        self.bind_name(node.name, frozenset({made}))

    def visit_Return(self, node: ast.Return) -> None:
        """Take note of one of the things that the function returns."""
        self._returned(self.value(node.value))

    def visit_Yield(self, node: ast.Yield) -> Values:
        """Take note of one of the things that a generator holds."""
        self._returned(held(self.value(node.value)))
        return ANYTHING

    def visit_Import(self, node: ast.Import) -> None:
        """Bind ``a`` for ``import a.b``, and what ``a.b`` is for ``import a.b as c``."""
        for alias in node.names:
            self._module(alias.name)
            top = alias.name.partition(".")[0]
            bound = alias.name if alias.asname else top
            self.bind_name(alias.asname or top, self._module(bound))

    def _module(self, name: str) -> Values:
        if self._imported(name) is not None:
            return frozenset({OwnModule(name)})
        return frozenset({Origin(canonical(name))})

    def _imported(self, name: str) -> Module | None:
        """Return a module beside the script, or None; the first time, it runs.

        The packages that it lies in run before it.
        """
        parts = name.split(".")
        for k in range(1, len(parts) + 1):
            module = self.program.module(".".join(parts[:k]))
            if module is not None and module.name not in self.program.begun:
                Interpreter(self.program, module).run()
        return self.program.module(name)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        """Bind what ``from a import b as c`` does, and take note of stars."""
        base = node.module or ""
        if node.level:
            parts = self.module.package.split(".") if self.module.package else []
            parts = parts[: len(parts) - node.level + 1]
            base = ".".join([*parts, *([node.module] if node.module else [])])
        own = self._imported(base) if base else None
        for alias in node.names:
            if alias.name == "*":
                self.module.stars.append(base)
                continue
            inner = f"{base}.{alias.name}".lstrip(".")
            if own is not None:
                values = module_attribute(self.program, own, alias.name) or self.program.absent
            elif self._imported(inner) is not None:
                values = frozenset({OwnModule(inner)})
            else:
                values = frozenset({Origin(canonical(inner))})
            self.program.values[alias] = values
            self.bind_name(alias.asname or alias.name, values)

    def generic_visit(self, node: ast.AST) -> Values:
        """Evaluate the expressions of a statement, and walk through those within it."""
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.expr):
                self.value(child)
            elif isinstance(child, ast.stmt):
                self.visit(child)
            else:
                self.generic_visit(child)
        return ANYTHING


def _scope_of(scope: Scope, name: str) -> Scope:
    """Return the function around that a ``nonlocal`` name belongs to."""
    around: Scope | None = scope
    while around is not None:
        if around.local is not None and name in around.local:
            return around
        around = around.parent
    return scope


def _joined(ends: Sequence[dict[str, Values]]) -> dict[str, Values]:
    """Join what names stand for at the ends of branches."""
    out: dict[str, Values] = {}
    for name in dict.fromkeys(name for end in ends for name in end):
        unbound = frozenset({UNBOUND}) if any(name not in end for end in ends) else NONE
        out[name] = unbound.union(*(end.get(name, NONE) for end in ends))
    return out


def _leaves(body: Sequence[ast.stmt]) -> bool:
    """Whether a branch ends by leaving, so that nothing after it goes on from there."""
    if not body:
        return False
    last = body[-1]
    if isinstance(last, (ast.Return, ast.Raise)):
        return True
    return isinstance(last, ast.Expr) and ast.unparse(last.value) in (
        "sys.exit()", "exit()", "quit()",
    )  # fmt: skip
