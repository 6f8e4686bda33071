"""What the targets of assignments are bound to: names, attributes, items, and several at once."""

from __future__ import annotations

import ast

from rps_compat.scripts.expressions import Evaluator
from rps_compat.scripts.lookup import attribute
from rps_compat.scripts.values import (
    ANYTHING,
    NONE,
    UNBOUND,
    Class,
    Held,
    Instance,
    Origin,
    Values,
    elements,
    held,
)


class Binder(Evaluator):
    """Evaluates expressions, and binds what is assigned; for arguments see `Evaluator`."""

    def bind(self, target: ast.expr, values: Values) -> None:
        """Let the target of an assignment stand for something."""
        if isinstance(target, ast.Name):
            self.program.values[target] |= values
            self.bind_name(target.id, values)
        elif isinstance(target, ast.Attribute):
            self._bind_attribute(target, values)
        elif isinstance(target, ast.Subscript):
            self.value(target.value)
            self.value(target.slice)
            self.put_into(target.value, values)
        elif isinstance(target, ast.Starred):
            self.bind(target.value, held(elements(values)))
        elif isinstance(target, (ast.Tuple, ast.List)):
            for part in target.elts:
                self.bind(part, elements(values))

    def bind_name(self, name: str, values: Values) -> None:
        """Let a name of the current scope stand for something.

        Parameters
        ----------
        name : str
            Name without dots; ``global`` and ``nonlocal`` are minded.
        values : frozenset
            What it may stand for.
        """
        if name in self.scope.elsewhere:
            self.program.add(self.scope.elsewhere[name].ever, name, values)
            return
        self.scope.names[name] = values
        if not self.scope.live:  # those of classes and comprehensions are made anew
            self.program.add(self.scope.ever, name, values - {UNBOUND})

    def _bind_attribute(self, target: ast.Attribute, values: Values) -> None:
        owners = self.value(target.value)
        self.program.values[target] |= attribute(self.program, owners, target.attr)
        for owner in owners:
            if isinstance(owner, (Instance, Class)):
                of = owner.of if isinstance(owner, Instance) else owner
                self.program.add(of.attributes, target.attr, values)
            elif not isinstance(owner, (Origin, Held)):
                self.program.add(self.program.loose, target.attr, values)

    def visit_NamedExpr(self, node: ast.NamedExpr) -> Values:
        """Bind in the scope around a comprehension, and return."""
        found = self.value(node.value)
        inner = self.scope
        while self.scope.live and self.scope.parent is not None and not self.scope.is_class:
            self.scope = self.scope.parent
        self.bind(node.target, found)
        self.scope = inner
        return found

    def visit_Assign(self, node: ast.Assign) -> None:
        """Bind the targets of ``a = b = value`` and ``a, b = c, d``."""
        values = self.value(node.value)
        for target in node.targets:
            if (
                isinstance(target, (ast.Tuple, ast.List))
                and isinstance(node.value, (ast.Tuple, ast.List))
                and len(target.elts) == len(node.value.elts)
                and not any(isinstance(p, ast.Starred) for p in (*target.elts, *node.value.elts))
            ):
                each = [self.program.values[part] for part in node.value.elts]
                for part, its in zip(target.elts, each, strict=True):
                    self.bind(part, its)
            else:
                self.bind(target, values)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        """Bind to what both containers hold, of ``a += b``."""
        both = self.value(node.value)
        if isinstance(node.target, ast.Name):
            both |= self.visit_Name(ast.Name(node.target.id, ast.Load()))
        elif isinstance(node.target, ast.Attribute):
            both |= self.value(node.target)
        inside = [value.values for value in both if isinstance(value, Held)]
        self.bind(node.target, held(NONE.union(*inside)) if inside else ANYTHING)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        """Bind to the value, or to what the annotation says."""
        told = self.annotated(node.annotation)
        if node.value is not None:
            self.bind(node.target, self.value(node.value) | told)
        elif told:
            self.bind(node.target, told)

    def visit_Delete(self, node: ast.Delete) -> None:
        """Unbind."""
        for target in node.targets:
            if isinstance(target, ast.Name):
                self.scope.names[target.id] = frozenset({UNBOUND})
            else:
                self.generic_visit(target)
