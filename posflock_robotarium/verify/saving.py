"""Whether data would be lost if a run were ended from outside.

A write is early when it happens while the robots drive, or in a place that still runs when a
``KeyboardInterrupt`` ends the loop. Data is at risk where every write is late.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

from posflock_robotarium.verify.files import catches, writes
from posflock_robotarium.verify.findings import Finding, Verdict
from posflock_robotarium.verify.source import Source, is_call_to, stepping_functions


def check_saving(source: Source) -> Iterator[Finding]:
    """Look for data that would be lost if the run were ended from outside."""
    if not source.stepping_loops:
        return
    last = max(loop.end_lineno or loop.lineno for loop in source.stepping_loops)
    written = [call for call in source.calls if writes(source, call)]
    safe = _safe_places(source)
    early = [call for call in written if call in safe or _is_during(source, call)]
    late = [call for call in written if call not in early and call.lineno > last]
    # Functions of the script count where they are called.
    late += [
        call
        for call in written
        if call not in early and call not in late and _only_called_after(source, call, last)
    ]
    if late and not early:
        first = min(late, key=lambda call: call.lineno)
        yield Finding(
            "save-at-end",
            Verdict.RISK,
            "saves its data only after the loop: a run that is interrupted, as four of ten"
            " published ones were, returns nothing",
            "write during the loop (numpy.lib.format.open_memmap, or posflock's PoseLog), or"
            " at least in `try: … finally:` around it",
            line=first.lineno,
        )


def _safe_places(source: Source) -> set[ast.AST]:
    """Everything that still runs when a KeyboardInterrupt ends a stepping loop."""
    found: set[ast.AST] = set()
    loops = set(source.stepping_loops)
    stepping = stepping_functions(source.tree)
    for node in ast.walk(source.tree):
        if isinstance(node, ast.Try) and any(
            inner in loops or is_call_to(inner, stepping)
            for statement in node.body
            for inner in ast.walk(statement)
        ):
            bodies = list(node.finalbody)
            caught = any(_catches_interrupt(handler) for handler in node.handlers)
            for handler in node.handlers:
                bodies += handler.body if _catches_interrupt(handler) else []
            for statement in bodies:
                found |= set(ast.walk(statement))
            if caught:  # what follows such a try runs as well
                found |= _after(source.tree, node)
    called = {node.id for node in found if isinstance(node, ast.Name)}
    called |= {
        argument.id
        for call in source.calls
        if source.called(call) == "atexit.register"
        for argument in call.args[:1]
        if isinstance(argument, ast.Name)
    }
    for node in ast.walk(source.tree):
        if isinstance(node, ast.FunctionDef) and node.name in called:
            found |= set(ast.walk(node))
    return found


def _after(tree: ast.Module, node: ast.stmt) -> set[ast.AST]:
    """Everything in the text after `node`."""
    end = node.end_lineno or node.lineno
    return {other for other in ast.walk(tree) if getattr(other, "lineno", 0) > end}


def _catches_interrupt(handler: ast.ExceptHandler) -> bool:
    return catches(handler, {"KeyboardInterrupt", "BaseException"})


def _is_during(source: Source, call: ast.Call) -> bool:
    """Whether a write happens while the robots drive, or before."""
    loops = source.stepping_loops
    first = min(loop.lineno for loop in loops)
    if any(call in set(ast.walk(loop)) for loop in loops):
        return True
    function = _function_of(source.tree, call)
    if function is None:
        return call.lineno < first
    stepping = stepping_functions(source.tree)
    if function.name in stepping:
        return call.lineno < first
    return any(is_call_to(inner, {function.name}) for loop in loops for inner in ast.walk(loop))


def _only_called_after(source: Source, call: ast.Call, last: int) -> bool:
    function = _function_of(source.tree, call)
    if function is None:
        return False
    uses = [
        node
        for node in ast.walk(source.tree)
        if is_call_to(node, {function.name}) and node not in set(ast.walk(function))
    ]
    return bool(uses) and all(getattr(use, "lineno", 0) > last for use in uses)


def _function_of(tree: ast.Module, node: ast.AST) -> ast.FunctionDef | None:
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef) and node in set(ast.walk(function)):
            return function
    return None
