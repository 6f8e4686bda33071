"""Whether data would be lost if a run were ended from outside.

A write is early when it happens while the robots drive, or in a place that still runs when a
``KeyboardInterrupt`` ends the loop. Data is at risk where every write is late.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Set
from pathlib import PurePath

from posflock_robotarium.verify.files import catches, path_written, writes
from posflock_robotarium.verify.findings import Code, Finding, Verdict
from posflock_robotarium.verify.source import Source, is_call_to


def check_saving(source: Source) -> Iterator[Finding]:
    """Look for data that would be lost if the run were ended from outside.

    Parameters
    ----------
    source : Source
        What the checks know of the script.
    """
    if not source.stepping_loops:
        return
    last = max(statement.end_lineno or statement.lineno for statement in _driving(source))
    written = [
        call for call in source.calls if writes(source, call) and not _is_elsewhere(source, call)
    ]
    safe = _safe_places(source)
    driving = {node for statement in _driving(source) for node in ast.walk(statement)}
    reached = _reached(source, driving)
    early = [call for call in written if call in safe or _is_during(source, call, driving, reached)]
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
            Code.SAVE_AT_END,
            Verdict.RISK,
            "saves its data only after the loop: a run that is interrupted, as four of ten"
            " published ones were, returns nothing",
            "write during the loop (numpy.lib.format.open_memmap, or posflock's PoseLog), or"
            " at least in `try: … finally:` around it",
            line=first.lineno,
        )


def _driving(source: Source) -> list[ast.stmt]:
    """Return what runs while the robots drive: the bodies of the loops, without their ``else``."""
    return [statement for loop in source.stepping_loops for statement in loop.body]


def _is_elsewhere(source: Source, call: ast.Call) -> bool:
    """Whether a write goes outside the working folder: the runs tell of that."""
    path = path_written(source, call)
    return path is not None and (PurePath(path).is_absolute() or ".." in PurePath(path).parts)


def _safe_places(source: Source) -> set[ast.AST]:
    """Everything that still runs when a KeyboardInterrupt ends a stepping loop."""
    found: set[ast.AST] = set()
    loops = set(source.stepping_loops)
    for node in ast.walk(source.tree):
        if isinstance(node, ast.Try) and any(
            inner in loops or is_call_to(inner, source.stepping, source.owners)
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
    called |= _reached(source, found)
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


def _is_during(source: Source, call: ast.Call, driving: Set[ast.AST], reached: Set[str]) -> bool:
    """Whether a write happens while the robots drive, or before."""
    first = min(loop.lineno for loop in source.stepping_loops)
    if call in driving:
        return True
    function = _function_of(source.tree, call)
    if function is None:
        return call.lineno < first
    if function.name in source.stepping:
        return call.lineno < first
    return function.name in reached


def _reached(source: Source, nodes: Iterable[ast.AST]) -> set[str]:
    """Names of the script's functions that these nodes call, directly or through others."""
    functions = [node for node in ast.walk(source.tree) if isinstance(node, ast.FunctionDef)]
    reached: set[str] = set()
    waiting = list(nodes)
    while waiting:
        found = [
            function
            for function in functions
            if function.name not in reached
            and any(is_call_to(node, {function.name}, source.owners) for node in waiting)
        ]
        reached |= {function.name for function in found}
        waiting = [node for function in found for node in ast.walk(function)]
    return reached


def _only_called_after(source: Source, call: ast.Call, last: int) -> bool:
    function = _function_of(source.tree, call)
    if function is None:
        return False
    uses = [
        node
        for node in ast.walk(source.tree)
        if is_call_to(node, {function.name}, source.owners) and node not in set(ast.walk(function))
    ]
    return bool(uses) and all(getattr(use, "lineno", 0) > last for use in uses)


def _function_of(tree: ast.Module, node: ast.AST) -> ast.FunctionDef | None:
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef) and node in set(ast.walk(function)):
            return function
    return None
