"""Which parts of a script never run on the testbed, and what a script is ready to do without.

Scripts that know several versions ask first: ``try`` and ``except ImportError``, ``hasattr``, a
comparison of ``sys.version_info``. What they ask about cannot stop them.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Sequence
from typing import Any

from rps_compat.scripts.libraries import PYTHON

_COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], bool]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
#: Exceptions whose handler is ready for a module, name, attribute or argument that is not there.
_MISSING = frozenset(
    {
        "AttributeError", "ImportError", "ModuleNotFoundError", "NameError", "RobotariumError",
        "TypeError", "WrongGenerationError",
    }
)  # fmt: skip
#: Exceptions whose handler may be ready for that, or may only tidy up after anything.
_ANYTHING = frozenset({"Exception", "BaseException"})
#: Statements in a ``try`` up to which a handler of anything is taken to be meant for them.
_FEW = 3


class Guards:
    """What guards the names of one module.

    Parameters
    ----------
    tree : ast.Module
        Syntax tree of that module.

    Attributes
    ----------
    unreached : set of ast.AST
        Nodes that never run on the testbed.
    ready : set of ast.AST
        Nodes whose failure the script catches, or that run after a failure.
    asked : set of str
        Names that the script asks for with ``hasattr`` or ``getattr``.
    """

    def __init__(self, tree: ast.Module) -> None:
        self.unreached: set[ast.AST] = set()
        self.ready: set[ast.AST] = set()
        self.asked: set[str] = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.If):
                self._branches(node)
            elif isinstance(node, ast.Try):
                if any(_is_ready(handler, node.body) for handler in node.handlers):
                    self._mark(self.ready, [*node.body, *node.handlers])
            elif isinstance(node, (ast.With, ast.AsyncWith)):
                if any(_suppresses(item.context_expr) for item in node.items):
                    self._mark(self.ready, node.body)
            elif isinstance(node, ast.Call):
                self._asks(node)

    def _branches(self, node: ast.If) -> None:
        taken = branch_taken(node.test)
        if taken is not None:
            self._mark(self.unreached, node.orelse if taken else node.body)
        elif "__version__" in ast.unparse(node.test):
            self._mark(self.ready, [*node.body, *node.orelse])

    @staticmethod
    def _mark(where: set[ast.AST], nodes: Sequence[ast.AST]) -> None:
        for node in nodes:
            where.update(ast.walk(node))

    def _asks(self, node: ast.Call) -> None:
        name = getattr(node.func, "id", "")
        if name in ("hasattr", "getattr") and len(node.args) > 1:
            asked = getattr(node.args[1], "value", None)
            if isinstance(asked, str):
                self.asked.add(asked)


def branch_taken(test: ast.expr) -> bool | None:
    """Return which way a test goes on the testbed, None if that is not known.

    Known are ``TYPE_CHECKING`` and comparisons of ``sys.version_info``.

    Parameters
    ----------
    test : ast.expr
        Condition of the ``if``.
    """
    name = test.attr if isinstance(test, ast.Attribute) else getattr(test, "id", "")
    if name == "TYPE_CHECKING":
        return False
    if not isinstance(test, ast.Compare) or len(test.ops) != 1:
        return None
    if ast.unparse(test.left) not in ("sys.version_info", "version_info", "sys.version_info[:2]"):
        return None
    try:
        asked = ast.literal_eval(test.comparators[0])
        version = PYTHON if "[" in ast.unparse(test.left) else (*PYTHON, 99)
        return _COMPARISONS[type(test.ops[0])](version, asked)
    except (ValueError, TypeError, KeyError):
        return None


def catches_import_error(handler: ast.ExceptHandler) -> bool:
    """Whether a handler runs when an import fails.

    Parameters
    ----------
    handler : ast.ExceptHandler
        An ``except`` with what it catches.
    """
    caught = _caught(handler)
    return caught is None or bool(caught & {"ImportError", "ModuleNotFoundError", *_ANYTHING})


def _caught(handler: ast.ExceptHandler) -> set[str] | None:
    """Names of the exceptions that a handler catches; None for all."""
    if handler.type is None:
        return None
    kinds = handler.type.elts if isinstance(handler.type, ast.Tuple) else [handler.type]
    return {getattr(kind, "id", getattr(kind, "attr", "")) for kind in kinds}


def _is_ready(handler: ast.ExceptHandler, body: Sequence[ast.stmt]) -> bool:
    """Whether a handler is ready for something missing in `body`.

    One that catches anything around a whole program is not.
    """
    caught = _caught(handler)
    if caught is not None and caught & _MISSING:
        return True
    if caught is not None and not caught & _ANYTHING:
        return False
    inside = [inner for node in body for inner in ast.walk(node) if isinstance(inner, ast.stmt)]
    return len(inside) <= _FEW and not any(isinstance(i, (ast.For, ast.While)) for i in inside)


def _suppresses(context: ast.expr) -> bool:
    """Whether a context manager is ``suppress(AttributeError)`` or the like."""
    if not isinstance(context, ast.Call):
        return False
    name = getattr(context.func, "id", getattr(context.func, "attr", ""))
    kinds = {getattr(kind, "id", getattr(kind, "attr", "")) for kind in context.args}
    return name == "suppress" and bool(kinds & (_MISSING | _ANYTHING))
