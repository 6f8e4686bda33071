"""What has to change in a script before the testbed of today runs it, with line numbers.

Three kinds of findings. *Names*: functions, attributes and arguments that generation 2 of the API
calls otherwise. *Defaults*: arguments that the script leaves out and that generation 2 fills in
differently, so that the same line does something else. *Versions*: names that numpy 2.2 no longer
has, and syntax or library names that Python 3.10 does not have yet; both are what the testbed runs.

Most findings come with edits. An edit replaces a stretch of the source and nothing else, so a
rewritten script keeps its formatting and comments; see :func:`rewritten`.
"""

import ast
import importlib
import inspect
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal

from rps_compat.errors import RobotariumError
from rps_compat.generations import ATTRIBUTES, FUNCTIONS, Kinds, evidence_of
from rps_compat.versions import version_findings

UTILITIES = ("barrier_certificates", "controllers", "graph", "misc", "transformations")
#: Arguments that both generations have under different names: function of generation 2 → names.
_RENAMED_ARGUMENTS = {
    "create_uni_barrier_certificate": {"magnitude_limit": "velocity_magnitude_limit"},
    "create_uni_barrier_certificate_with_boundary": {"magnitude_limit": "velocity_magnitude_limit"},
}
#: Generation 1 checks directly what generation 2 makes a checker for.
_CHECKS = {"at_pose": 2, "at_position": 2}
#: Generation 2 returns two functions where generation 1 returns the first of them.
_FIRST_OF_TWO = {"create_uni_to_si_dynamics"}
_CONSTRUCTOR = ("number_of_robots", "show_figure", "sim_in_real_time", "initial_conditions")
_DIFFERENT_MEANING = {
    "boundaries": "generation 2 has (x_min, x_max, y_min, y_max) where generation 1 has "
    "(x, y, width, height)"
}


class LintError(RobotariumError, ValueError):
    """A script that cannot be read as Python."""


@dataclass(frozen=True)
class Edit:
    """Bytes `start` to `end` of the source are replaced by `text`."""

    start: int
    end: int
    text: str


@dataclass(frozen=True)
class Finding:
    """Something to change.

    Attributes
    ----------
    line
        Where, counted from 1.
    kind
        "name", "default", "argument" or "version".
    message
        What is wrong and what is right.
    edits
        What rewriting does about it; none where a person has to decide.
    """

    line: int
    kind: Literal["name", "default", "argument", "version"]
    message: str
    edits: tuple[Edit, ...] = ()


def findings_in(source: bytes, name: str = "script") -> list[Finding]:
    """List what has to change in `source` for generation 2, numpy 2.2 and Python 3.10, by line.

    Raises
    ------
    LintError
        `source` is not Python; `name` says whose.
    """
    try:
        tree = ast.parse(source, name)
    except (SyntaxError, ValueError) as error:
        raise LintError(f"{name} is not a Python script: {error}") from error
    text = _Text(source)
    found = list(_Names(tree, text).findings())
    found += [
        Finding(line, "version", message, _edit_of(text, node, replacement))
        for line, message, node, replacement in version_findings(tree, source)
    ]
    # What is wrong several times in one line is told once, with all its edits.
    merged: dict[tuple[int, str, str], Finding] = {}
    for finding in found:
        key = finding.line, finding.message, finding.kind
        edits = merged[key].edits if key in merged else ()
        more = tuple(edit for edit in finding.edits if edit not in edits)
        merged[key] = replace(finding, edits=edits + more)
    return [merged[key] for key in sorted(merged)]


def rewritten(source: bytes, findings: list[Finding]) -> bytes:
    """Return `source` with the edits of all `findings` made; the rest stays as it was."""
    edits = sorted({edit for finding in findings for edit in finding.edits}, key=_order)
    out, done = bytearray(), 0
    for edit in edits:
        if edit.start < done:  # inside what another edit has replaced already
            continue
        out += source[done : edit.start] + edit.text.encode()
        done = edit.end
    return bytes(out + source[done:])


def lint_script(script: Path) -> tuple[bytes, list[Finding]]:
    """Read `script` and list its findings.

    Raises
    ------
    LintError
        It cannot be read, or is not Python.
    """
    try:
        source = script.read_bytes()
    except OSError as error:
        raise LintError(f"{script}: {error.strerror or error}") from error
    return source, findings_in(source, str(script))


def _order(edit: Edit) -> tuple[int, int]:
    return edit.start, edit.end


class _Text:
    """Byte offsets of syntax nodes, which know lines and columns."""

    def __init__(self, source: bytes) -> None:
        self.source = source
        self._starts = [0]
        for line in source.splitlines(keepends=True):
            self._starts.append(self._starts[-1] + len(line))
        # ast does not count a byte order mark
        self._mark = 3 if source.startswith(b"\xef\xbb\xbf") else 0

    def start(self, node: Any) -> int:
        return self._at(node.lineno, node.col_offset)

    def end(self, node: Any) -> int:
        return self._at(node.end_lineno, node.end_col_offset)

    def _at(self, line: int, column: int) -> int:
        return self._starts[line - 1] + column + (self._mark if line == 1 else 0)

    def of(self, node: Any) -> str:
        return self.source[self.start(node) : self.end(node)].decode()


def _edit_of(text: _Text, node: Any, replacement: str | None) -> tuple[Edit, ...]:
    if node is None or replacement is None:
        return ()
    return (Edit(text.start(node), text.end(node), replacement),)


@cache
def _parameters(generation: int, function: str) -> dict[str, Any]:
    """Parameters of a utility of `generation` and their defaults, in order."""
    for module in UTILITIES:
        found = getattr(
            importlib.import_module(f"rps_compat.v{generation}.utilities.{module}"), function, None
        )
        if found is not None:
            parameters = inspect.signature(found).parameters.values()
            return {parameter.name: parameter.default for parameter in parameters}
    return {}


class _Names:
    """Findings about the API's names, arguments and defaults in one script."""

    def __init__(self, tree: ast.Module, text: _Text) -> None:
        self._tree, self._text = tree, text
        kinds = Kinds(tree)
        self._instances, self._makers = kinds.instances, kinds.makers
        self._super_calls = kinds.super_calls(tree)
        # In a script of generation 2 the functions that both have mean generation 2's defaults.
        self._second = evidence_of([tree]).generation == 2
        self._aliases = {
            alias.asname
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom)
            for alias in node.names
            if alias.asname
        }
        self._own = {
            node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.ClassDef)
        }

    def findings(self) -> Iterator[Finding]:
        for node in ast.walk(self._tree):
            if isinstance(node, ast.ImportFrom):
                yield from self._import(node)
            elif isinstance(node, ast.Attribute):
                yield from self._attribute(node)
            elif isinstance(node, ast.Call):
                yield from self._call(node)

    def _import(self, node: ast.ImportFrom) -> Iterator[Finding]:
        module = node.module or ""
        if not module.startswith("rps."):
            return
        if module == "rps.utilities.barrier_certificates2":
            yield Finding(node.lineno, "name", f"{module} is gone in generation 2")
        present = {alias.name for alias in node.names}
        for alias in node.names:
            if alias.name not in FUNCTIONS:
                continue
            new = FUNCTIONS[alias.name]
            if new is None:
                yield Finding(node.lineno, "name", _no_like(alias.name))
                continue
            # Two old names may become one: `import a, a` is harmless, so no special case.
            edit = Edit(self._text.start(alias), self._text.start(alias) + len(alias.name), new)
            present.add(new)
            yield Finding(node.lineno, "name", _renamed(alias.name, new), (edit,))

    def _attribute(self, node: ast.Attribute) -> Iterator[Finding]:
        new = ATTRIBUTES.get(node.attr)
        if new is None:
            return
        known = ast.unparse(node.value) in self._instances
        if not known and node.attr != "call_at_scripts_end":
            return
        end = self._text.end(node)
        edits: tuple[Edit, ...] = (Edit(end - len(node.attr), end, new),)
        message = _renamed(node.attr, new)
        if node.attr in _DIFFERENT_MEANING:
            message, edits = f"{message}; {_DIFFERENT_MEANING[node.attr]}", ()
        yield Finding(node.lineno, "name", message, edits)

    def _call(self, node: ast.Call) -> Iterator[Finding]:
        name = getattr(node.func, "id", getattr(node.func, "attr", ""))
        if name in self._makers or node in self._super_calls:
            yield from self._constructor(node)
        elif name == "set_velocities" and node.args and not self._second:
            yield from self._ids(node)
        elif name in self._own:
            return
        elif name in _CHECKS:
            yield from self._check(node, name)
        elif name in FUNCTIONS or (not self._second and _parameters(1, name)):
            yield from self._utility(node, name)

    def _constructor(self, node: ast.Call) -> Iterator[Finding]:
        if not node.args or any(isinstance(a, ast.Starred) for a in node.args):
            return
        edits = tuple(
            Edit(self._text.start(argument), self._text.start(argument), f"{name}=")
            for name, argument in zip(_CONSTRUCTOR, node.args, strict=False)
        )
        message = "generation 2 takes the arguments of Robotarium by name only"
        yield Finding(node.lineno, "argument", message, edits)

    def _ids(self, node: ast.Call) -> Iterator[Finding]:
        ids = node.args[0]
        if isinstance(ids, ast.Constant | ast.List) and (
            not isinstance(ids, ast.List) or len(ids.elts) < 2
        ):
            yield Finding(
                node.lineno,
                "argument",
                f"set_velocities({self._text.of(ids)}, ...): generation 1 ignores the ids, "
                "generation 2 commands these robots only; pass np.arange(N) for all",
            )

    def _check(self, node: ast.Call, name: str) -> Iterator[Finding]:
        """``at_pose(x, goal, e, r)`` → ``create_at_pose(e, r)(x, goal)[1].nonzero()``."""
        new, first = FUNCTIONS[name], _CHECKS[name]
        names = list(_parameters(1, name))[:first]
        given = {**dict(zip(names, node.args, strict=False))}
        given |= {k.arg: k.value for k in node.keywords if k.arg in names}
        options = [self._text.of(argument) for argument in node.args[first:]]
        options += [
            f"{k.arg}={self._text.of(k.value)}" for k in node.keywords if k.arg not in names
        ]
        if name == "at_position" and not options:
            options = ["position_error=0.02"]
        message = f"{_renamed(name, new)}: a function that makes the check"
        if len(given) < len(names):
            yield Finding(node.lineno, "name", message)
            return
        what = ", ".join(self._text.of(given[parameter]) for parameter in names)
        call = f"{self._prefix(node)}{new}({', '.join(options)})({what})[1].nonzero()"
        edit = Edit(self._text.start(node), self._text.end(node), call)
        yield Finding(node.lineno, "name", message, (edit,))

    def _prefix(self, node: ast.Call) -> str:
        return f"{self._text.of(node.func.value)}." if isinstance(node.func, ast.Attribute) else ""

    def _utility(self, node: ast.Call, name: str) -> Iterator[Finding]:
        new = FUNCTIONS.get(name, name)
        if new is None:
            yield Finding(node.lineno, "name", _no_like(name))
            return
        old_ones, new_ones = _parameters(1, name), _parameters(2, new)
        if not new_ones or any(isinstance(a, ast.Starred) for a in node.args):
            return
        edits: list[Edit] = []
        if new != name:
            end = self._text.end(node.func)
            edits.append(Edit(end - len(name), end, new))
            yield Finding(node.lineno, "name", _renamed(name, new), tuple(edits))
        if name in _FIRST_OF_TWO:
            end = self._text.end(node)
            yield Finding(
                node.lineno,
                "name",
                f"{new} returns two functions, {name} the first of them",
                (Edit(end, end, "[0]"),),
            )
        yield from self._arguments(node, name, new, old_ones, new_ones)

    def _arguments(
        self, node: ast.Call, name: str, new: str, old: dict[str, Any], fresh: dict[str, Any]
    ) -> Iterator[Finding]:
        renamed = {**_by_position(old, fresh), **_RENAMED_ARGUMENTS.get(new, {})}
        given: dict[str, ast.expr] = dict(zip(old, node.args, strict=False))
        given |= {k.arg: k.value for k in node.keywords if k.arg}
        kept, changed = [], False
        for position, (argument, value) in enumerate(given.items()):
            target = renamed.get(argument, argument)
            if target not in fresh and argument in old:
                changed = True
                yield Finding(
                    node.lineno, "argument", f"{new} has no argument {argument}; it is left out"
                )
                continue
            text = self._text.of(value)
            if position < len(node.args) and not changed and list(fresh).index(target) == position:
                kept.append(text)
                continue
            changed |= position < len(node.args) or target != argument
            kept.append(f"{target}={text}")
        for argument, default in old.items():
            target = renamed.get(argument, argument)
            if argument in given or target in given or target not in fresh:
                continue
            if default is not inspect.Parameter.empty and not _same(default, fresh[target]):
                changed = True
                kept.append(f"{target}={_written(default)}")
                yield Finding(
                    node.lineno,
                    "default",
                    f"{argument} of {name} is {_written(default)} by default, "
                    f"in generation 2 {_written(fresh[target])}",
                )
        if changed and not any(keyword.arg is None for keyword in node.keywords):
            opening = self._text.source.index(b"(", self._text.end(node.func)) + 1
            edit = Edit(opening, self._text.end(node) - 1, ", ".join(kept))
            message = f"arguments of {new} in generation 2: {', '.join(kept) or 'none'}"
            yield Finding(node.lineno, "argument", message, (edit,))


def _by_position(old: dict[str, Any], fresh: dict[str, Any]) -> dict[str, str]:
    """Names of generation 2 for required arguments, which keep their places: ``N`` → ``n``.

    Optional arguments are not matched so: what stands in one's place is often something else.
    """
    return {
        argument: target
        for (argument, default), target in zip(old.items(), fresh, strict=False)
        if default is inspect.Parameter.empty and argument not in fresh and target not in old
    }


def _same(one: Any, other: Any) -> bool:
    if other is None:  # generation 2 leaves the arena's own boundaries out
        return hasattr(one, "shape")
    try:
        return bool((one == other) is True or (one == other).all())
    except (AttributeError, ValueError):
        return False


def _written(value: Any) -> str:
    return str(value.tolist()) if hasattr(value, "tolist") else repr(value)


def _renamed(old: str, new: str | None) -> str:
    return f"{old} is a name of generation 1; generation 2 calls it {new}"


def _no_like(name: str) -> str:
    return f"{name} is a name of generation 1; generation 2 has nothing like it"
