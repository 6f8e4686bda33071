"""What a script's source says about its chances, without running it.

Each check is one function that takes a :class:`Source` and yields findings; :data:`CHECKS` lists
them.  They read the syntax tree, so a name in a comment or a string is no finding, and they give
the line.  A check speaks only when it is sure: what cannot be read off the source is left to the
trial runs.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path, PurePath
from typing import Any

from posflock_robotarium import import_graph, testbed
from posflock_robotarium.verify import generations, newer_python
from posflock_robotarium.verify.constants import SCRIPT, constant, constants_of
from posflock_robotarium.verify.findings import Finding, Verdict

#: Exceptions whose handler is prepared for a file that is not there.
_NO_FILE = {"FileNotFoundError", "OSError", "IOError", "Exception", "BaseException"}
_FINISHING = ("debug", "call_at_scripts_end")
#: Functions that read a file whose path is their first argument.
_READERS = frozenset(
    [
        "numpy.load",
        "numpy.loadtxt",
        "numpy.genfromtxt",
        "numpy.fromfile",
        "numpy.memmap",
        "scipy.io.loadmat",
        "matplotlib.pyplot.imread",
        "matplotlib.image.imread",
        "PIL.Image.open",
        "cv2.imread",
        "torch.load",
    ]
)
#: Functions that write a file.
_WRITERS = frozenset(
    [
        "numpy.save",
        "numpy.savez",
        "numpy.savez_compressed",
        "numpy.savetxt",
        "scipy.io.savemat",
        "pickle.dump",
        "json.dump",
        "torch.save",
        "cv2.imwrite",
        "yaml.dump",
        "joblib.dump",
        "matplotlib.pyplot.savefig",
    ]
)
_WRITING_METHODS = frozenset(["tofile", "savefig", "write_text", "write_bytes", "to_csv"])
_BLOCKING = {
    "input": "waits for a key",
    "builtins.input": "waits for a key",
    "breakpoint": "waits for a debugger",
    "pdb.set_trace": "waits for a debugger",
    "getpass.getpass": "waits for a password",
    "os.system": "",
    "matplotlib.pyplot.show": "waits until its window is closed",
    "matplotlib.pyplot.waitforbuttonpress": "waits for a key",
    "matplotlib.pyplot.ginput": "waits for a click",
    "sys.stdin.read": "waits for a line",
    "sys.stdin.readline": "waits for a line",
}
del _BLOCKING["os.system"]


@dataclass
class Source:
    """A script that parses, with what every check needs of it.

    Attributes
    ----------
    path : Path
        Where it lies.
    text : str
        Its source.
    tree : ast.Module
        Parsed.
    generation : int
        Of the testbed's API that it is to run on, 1 or 2.
    search : tuple of Path
        Where local modules may lie, besides its own folder.
    """

    path: Path
    text: str
    tree: ast.Module
    generation: int = 2
    search: tuple[Path, ...] = ()
    names: dict[str, Any] = field(init=False)

    def __post_init__(self) -> None:
        self.names = constants_of(self.tree)

    @cached_property
    def aliases(self) -> dict[str, str]:
        """What each imported name stands for, as a dotted path."""
        found: dict[str, str] = {}
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Import):
                for alias in node.names:
                    top = alias.name.partition(".")[0]
                    found[alias.asname or top] = alias.name if alias.asname else top
            elif isinstance(node, ast.ImportFrom) and not node.level:
                for alias in node.names:
                    found[alias.asname or alias.name] = f"{node.module}.{alias.name}"
        # rps's modules hand these on to whoever takes a star from them.
        if any(name.endswith(".*") and name.startswith("rps.") for name in found.values()):
            found.setdefault("np", "numpy")
            found.setdefault("plt", "matplotlib.pyplot")
            found.setdefault("time", "time")
        return found

    @cached_property
    def trace(self) -> import_graph.Trace:
        """Everything it imports."""
        return import_graph.trace(self.path, self.search)

    def called(self, call: ast.Call) -> str:
        """Return the dotted path of what is called, as ``numpy.load``; empty if unknown."""
        parts: list[str] = []
        node: ast.expr = call.func
        while isinstance(node, ast.Attribute):
            parts.append(node.attr)
            node = node.value
        if not isinstance(node, ast.Name):
            return ""
        return ".".join([self.aliases.get(node.id, node.id), *reversed(parts)])

    @cached_property
    def calls(self) -> list[ast.Call]:
        """Every call, in the order of the text."""
        found = [node for node in ast.walk(self.tree) if isinstance(node, ast.Call)]
        return sorted(found, key=lambda call: (call.lineno, call.col_offset))

    @cached_property
    def stepping_loops(self) -> list[ast.For | ast.While]:
        """Outermost loops that drive the robots: that step, or call a function that does."""
        stepping = _stepping_functions(self.tree)
        found: list[ast.For | ast.While] = []

        def look(node: ast.AST) -> None:
            for child in ast.iter_child_nodes(node):
                if isinstance(child, (ast.For, ast.While)) and _steps(child, stepping):
                    found.append(child)
                else:
                    look(child)

        look(self.tree)
        return found


def check_source(
    script: Path, generation: int = 2, search: tuple[Path, ...] = ()
) -> tuple[list[Finding], Source | None]:
    """Return all that the source of `script` says, and the source itself where it parses.

    Raises
    ------
    ScriptError
        Where the file cannot be read.
    """
    text = import_graph.read_source(script)
    try:
        tree = ast.parse(text, filename=str(script))
    except (SyntaxError, ValueError) as error:
        line = getattr(error, "lineno", None)
        reason = getattr(error, "msg", None) or str(error)
        return [
            Finding(
                "syntax",
                Verdict.FAIL,
                f"Python cannot read it: {reason}",
                "mend the line; `python -m py_compile` shows the place",
                line=line,
            )
        ], None
    source = Source(Path(script), text, tree, generation, search)
    findings = [finding for check in CHECKS for finding in check(source)]
    return sorted(findings, key=lambda finding: (finding.file, finding.line or 0)), source


# --- Python and libraries ----------------------------------------------------------------------


def check_python(source: Source) -> Iterator[Finding]:
    """Syntax and library of Python 3.10, names of numpy 2."""
    advice = "the testbed runs Python 3.10; write it the older way"
    syntax = newer_python.newer_syntax(source.text)
    if syntax:
        line, reason = syntax
        yield Finding(
            "newer-python", Verdict.FAIL, f"newer than Python 3.10: {reason}", advice, line=line
        )
    for line, name in newer_python.newer_library(source.tree):
        yield Finding(
            "newer-python", Verdict.FAIL, f"{name} is newer than Python 3.10", advice, line=line
        )
    for line, name, instead in newer_python.removed_from_numpy(source.tree):
        yield Finding(
            "removed-from-numpy",
            Verdict.FAIL,
            f"numpy.{name} is gone from numpy {testbed.LIBRARIES['numpy']}",
            f"write {instead}",
            line=line,
        )


def check_imports(source: Source) -> Iterator[Finding]:
    """Libraries the testbed lacks, files that are missing or must be uploaded, hidden names."""
    try:
        trace = source.trace
    except import_graph.ScriptError as error:
        yield Finding("syntax", Verdict.FAIL, str(error), "mend the imported file")
        return
    for missing in trace.missing:
        if missing.statement.top in testbed.NEWER_MODULES:
            continue  # told of as newer than Python 3.10
        yield _missing(source, missing)
    for local in trace.locals:
        hidden = testbed.shadowed_by(local.name) if "." not in local.name else None
        if hidden and not local.is_package:
            yield Finding(
                "shadowed-name",
                Verdict.FAIL,
                f"{local.path.name} would hide {hidden}",
                "rename the file",
                line=local.line,
                file=_file(source, local.wanted_by),
            )
    if trace.locals and not any(testbed.shadowed_by(local.name) for local in trace.locals):
        first = trace.locals[0]
        names = sorted({local.name.partition(".")[0] for local in trace.locals})
        yield Finding(
            "local-module",
            Verdict.NOTE,
            f"{len(trace.locals)} local file{'s' * (len(trace.locals) > 1)} must be uploaded with"
            f" it: {', '.join(names)}",
            f"`posflock bundle {source.path.name} -o upload` lays them flat",
            line=first.line,
        )


def _missing(source: Source, missing: import_graph.Missing) -> Finding:
    statement = missing.statement
    place: dict[str, Any] = {"line": statement.line, "file": _file(source, missing.wanted_by)}
    if statement.top == testbed.STAND_IN:
        return Finding(
            "stand-in",
            Verdict.FAIL,
            f"{statement.module} stands in for rps on this machine only",
            "import rps, and rps_compat in `except ImportError`",
            **place,
        )
    if statement.relative:
        return Finding(
            "module-missing",
            Verdict.FAIL,
            f"the relative import of {statement.module or 'its own package'!r} needs a package,"
            " but the main file is none",
            "import it by its plain name",
            **place,
        )
    if statement.top in testbed.ABSENT:
        return Finding(
            "library-absent",
            Verdict.FAIL,
            f"the testbed has no {statement.top}",
            testbed.ABSENT[statement.top],
            **place,
        )
    if missing.installed_here:
        return Finding(
            "library-absent",
            Verdict.FAIL,
            f"{statement.top} is not in the testbed's list of libraries",
            "do without it, or put its source files beside the script",
            **place,
        )
    return Finding(
        "module-missing",
        Verdict.FAIL,
        f"there is no module {statement.module}: neither beside the script nor on the testbed",
        f"put {statement.top}.py beside {source.path.name}, or correct the name",
        **place,
    )


def check_generation(source: Source) -> Iterator[Finding]:
    """Names of the other generation of the API."""
    for line, name, right in generations.wrong_names(source.tree, source.generation):
        yield Finding(
            "generation",
            Verdict.FAIL,
            f"{name} is a name of generation {3 - source.generation} of the API; the testbed"
            f" it is checked for runs generation {source.generation}",
            f"write {right}" if right else f"generation {source.generation} has no such thing",
            line=line,
        )


# --- What it does ------------------------------------------------------------------------------


def check_robots(source: Source) -> Iterator[Finding]:
    """Count the robots asked for."""
    for call in source.calls:
        if source.called(call).rpartition(".")[2] != "Robotarium":
            continue
        given = [k.value for k in call.keywords if k.arg == "number_of_robots"] or call.args[:1]
        number = constant(given[0], source.names) if given else None
        if isinstance(number, (int, float)) and number > testbed.MAX_ROBOTS:
            yield Finding(
                "too-many-robots",
                Verdict.FAIL,
                f"asks for {number} robots; the testbed has {testbed.MAX_ROBOTS}, though the"
                " simulator takes 50",
                f"use at most {testbed.MAX_ROBOTS}",
                line=call.lineno,
                figure=float(number),
                unit="robots",
            )


def check_finishing(source: Source) -> Iterator[Finding]:
    """Look for the call that ends an experiment."""
    made = [c for c in source.calls if source.called(c).rpartition(".")[2] == "Robotarium"]
    if not made:
        return
    named = {n.attr for n in ast.walk(source.tree) if isinstance(n, ast.Attribute)}
    named |= {
        n.value
        for n in ast.walk(source.tree)
        if isinstance(n, ast.Constant) and isinstance(n.value, str)
    }
    if not named & set(_FINISHING):
        right = _FINISHING[0] if source.generation == 2 else _FINISHING[1]
        yield Finding(
            "no-finishing-call",
            Verdict.RISK,
            f"never calls {right}(), so the run does not end in order and says nothing about its"
            " violations",
            f"end the script with r.{right}()",
            line=made[-1].lineno,
        )


def check_blocking(source: Source) -> Iterator[Finding]:
    """Look for calls that wait for somebody who is not there, and for sleeps."""
    in_loops = {call for loop in source.stepping_loops for call in ast.walk(loop)}
    for call in source.calls:
        name = source.called(call)
        if name in _BLOCKING:
            blocks = [k.value for k in call.keywords if k.arg == "block"] or (
                call.args[:1] if name.endswith(".show") else []
            )
            if blocks and constant(blocks[0], source.names) is False:
                continue
            yield Finding(
                "blocking-call",
                Verdict.FAIL,
                f"{name}() {_BLOCKING[name]}: on the testbed nobody is there",
                "remove it"
                + (", or save the figure with savefig" if name.endswith(".show") else ""),
                line=call.lineno,
            )
        elif name == "time.sleep" and call in in_loops and call.args:
            seconds = constant(call.args[0], source.names)
            if isinstance(seconds, (int, float)) and seconds > testbed.TIME_STEP:
                long = seconds >= testbed.WATCHDOG
                yield Finding(
                    "slow-sleep",
                    Verdict.RISK,
                    f"sleeps {seconds:g} s in its loop, longer than a step of"
                    f" {testbed.TIME_STEP} s"
                    + (": robots brake after 0.5 s without a command" if long else ""),
                    "remove it: r.step() keeps the time",
                    line=call.lineno,
                    figure=float(seconds),
                    unit="s",
                )


def check_saving(source: Source) -> Iterator[Finding]:
    """Look for data that would be lost if the run were ended from outside."""
    if not source.stepping_loops:
        return
    last = max(loop.end_lineno or loop.lineno for loop in source.stepping_loops)
    writes = [call for call in source.calls if _writes(source, call)]
    safe = _safe_places(source)
    early = [call for call in writes if call in safe or _is_during(source, call)]
    late = [call for call in writes if call not in early and call.lineno > last]
    # Functions of the script count where they are called.
    late += [
        call
        for call in writes
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


def check_files(source: Source) -> Iterator[Finding]:
    """Files it reads: there, flat, with an ending that may be uploaded."""
    written = {path for call in source.calls if (path := _path_written(source, call)) is not None}
    for call, path in files_read(source):
        line = call.lineno
        if path in written or (call.args and not path):
            continue
        pure = PurePath(path)
        if pure.is_absolute() or len(pure.parts) > 1:
            yield Finding(
                "file-in-folder",
                Verdict.FAIL,
                f"reads {path}, but uploads are flat: there are no folders beside the script",
                f"put {pure.name} beside the script and read {pure.name!r}",
                line=line,
            )
        elif pure.suffix.lower() not in testbed.ENDINGS:
            yield Finding(
                "file-ending",
                Verdict.FAIL,
                f"reads {path}, but files that end in {pure.suffix or 'nothing'} cannot be"
                " uploaded",
                f"use one of {' '.join(testbed.ENDINGS)}; .npy holds any array",
                line=line,
            )
        elif not (source.path.parent / path).is_file():
            yield Finding(
                "file-missing",
                Verdict.FAIL,
                f"reads {path}, which is not beside the script",
                f"put {path} into {source.path.resolve().parent}",
                line=line,
            )


def files_read(source: Source) -> Iterator[tuple[ast.Call, str]]:
    """Yield the calls that read a file whose path is known, with the path.

    A file that the script is prepared to miss counts only where it is there.
    """
    prepared = _prepared_for_absence(source.tree)
    for call in source.calls:
        name = source.called(call)
        method = call.func.attr if isinstance(call.func, ast.Attribute) else ""
        if name in _READERS or (name == "open" and _mode(source, call)[:1] == "r"):
            named = [k.value for k in call.keywords if k.arg in ("file", "fname", "filename")]
            path = constant((*call.args, *named)[0], source.names) if call.args or named else None
        elif method in ("read_text", "read_bytes") or (
            _opens_path(source, call) and _mode(source, call)[:1] == "r"
        ):
            path = constant(call.func.value, source.names)  # type: ignore[attr-defined]
        else:
            continue
        if not isinstance(path, (str, PurePath)) or path == SCRIPT:
            continue
        if call not in prepared or (source.path.parent / path).is_file():
            yield call, str(path)


def _opens_path(source: Source, call: ast.Call) -> bool:
    """``path.open()``, of a path that is known."""
    return (
        isinstance(call.func, ast.Attribute)
        and call.func.attr == "open"
        and isinstance(constant(call.func.value, source.names), PurePath)
    )


def _path_written(source: Source, call: ast.Call) -> str | None:
    if not _writes(source, call):
        return None
    of_path = _opens_path(source, call) or source.called(call) == ""
    method = call.func.attr if isinstance(call.func, ast.Attribute) else ""
    if isinstance(call.func, ast.Attribute) and (
        of_path or method in ("write_text", "write_bytes")
    ):
        path = constant(call.func.value, source.names)
    else:
        path = constant(call.args[0], source.names) if call.args else None
    if not isinstance(path, (str, PurePath)):
        return None
    ending = {"save": ".npy", "savez": ".npz", "savez_compressed": ".npz"}.get(method, "")
    return str(path) if str(path).endswith(ending) else f"{path}{ending}"


def _prepared_for_absence(tree: ast.Module) -> set[ast.AST]:
    """Everything that runs only if a file is there, or where a missing file is caught."""
    found: set[ast.AST] = set()
    for node in ast.walk(tree):
        bodies: list[ast.AST] = []
        if isinstance(node, ast.If) and _asks_for_a_file(node.test):
            bodies = [*node.body, *node.orelse]
        elif isinstance(node, ast.IfExp) and _asks_for_a_file(node.test):
            bodies = [node.body, node.orelse]
        elif (
            isinstance(node, ast.Try)
            and any(_catches(handler, _NO_FILE) for handler in node.handlers)
        ) or (
            isinstance(node, ast.With)
            and any("suppress(" in ast.unparse(item) for item in node.items)
        ):
            bodies = list(node.body)
        for body in bodies:
            found |= set(ast.walk(body))
    return found


def _asks_for_a_file(test: ast.expr) -> bool:
    return any(
        isinstance(node, ast.Call)
        and getattr(node.func, "attr", getattr(node.func, "id", ""))
        in ("exists", "is_file", "isfile")
        for node in ast.walk(test)
    )


def _mode(source: Source, call: ast.Call) -> str:
    first = 0 if _opens_path(source, call) else 1
    given = [k.value for k in call.keywords if k.arg == "mode"] or call.args[first : first + 1]
    mode = constant(given[0], source.names) if given else "r"
    return mode.replace("b", "").replace("t", "") if isinstance(mode, str) else "?"


def _writes(source: Source, call: ast.Call) -> bool:
    name = source.called(call)
    opens = name == "open" or _opens_path(source, call)
    if name in _WRITERS or (opens and _mode(source, call)[:1] in ("w", "a", "x")):
        return True
    method = call.func.attr if isinstance(call.func, ast.Attribute) else ""
    return method in _WRITING_METHODS


def _safe_places(source: Source) -> set[ast.AST]:
    """Everything that still runs when a KeyboardInterrupt ends a stepping loop."""
    found: set[ast.AST] = set()
    loops = set(source.stepping_loops)
    stepping = _stepping_functions(source.tree)
    for node in ast.walk(source.tree):
        if isinstance(node, ast.Try) and any(
            inner in loops or _is_call_to(inner, stepping)
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
    return _catches(handler, {"KeyboardInterrupt", "BaseException"})


def _catches(handler: ast.ExceptHandler, wanted: set[str]) -> bool:
    kinds = handler.type.elts if isinstance(handler.type, ast.Tuple) else [handler.type]
    names = {kind.id for kind in kinds if isinstance(kind, ast.Name)}
    return handler.type is None or bool(names & wanted)


def _is_during(source: Source, call: ast.Call) -> bool:
    """Whether a write happens while the robots drive, or before."""
    loops = source.stepping_loops
    first = min(loop.lineno for loop in loops)
    if any(call in set(ast.walk(loop)) for loop in loops):
        return True
    function = _function_of(source.tree, call)
    if function is None:
        return call.lineno < first
    stepping = _stepping_functions(source.tree)
    if function.name in stepping:
        return call.lineno < first
    return any(_is_call_to(inner, {function.name}) for loop in loops for inner in ast.walk(loop))


def _only_called_after(source: Source, call: ast.Call, last: int) -> bool:
    function = _function_of(source.tree, call)
    if function is None:
        return False
    uses = [
        node
        for node in ast.walk(source.tree)
        if _is_call_to(node, {function.name}) and node not in set(ast.walk(function))
    ]
    return bool(uses) and all(getattr(use, "lineno", 0) > last for use in uses)


def _function_of(tree: ast.Module, node: ast.AST) -> ast.FunctionDef | None:
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef) and node in set(ast.walk(function)):
            return function
    return None


def _stepping_functions(tree: ast.Module) -> set[str]:
    """Names of functions of the script that step, directly or through another."""
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    stepping: set[str] = set()
    while True:
        found = {f.name for f in functions if _steps(f, stepping)}
        if found == stepping:
            return stepping
        stepping = found


def _steps(node: ast.AST, stepping: set[str]) -> bool:
    return any(
        _is_call_to(inner, stepping)
        or (
            isinstance(inner, ast.Call)
            and isinstance(inner.func, ast.Attribute)
            and inner.func.attr == "step"
            and not inner.args
            and not inner.keywords
        )
        for inner in ast.walk(node)
    )


def _is_call_to(node: ast.AST, names: set[str]) -> bool:
    if not isinstance(node, ast.Call):
        return False
    func = node.func
    if isinstance(func, ast.Name):
        return func.id in names
    return (
        isinstance(func, ast.Attribute)
        and isinstance(func.value, ast.Name)
        and func.value.id == "self"
        and func.attr in names
    )


def _file(source: Source, path: Path) -> str:
    return "" if path == source.path.resolve() else path.name


CHECKS: tuple[Callable[[Source], Iterator[Finding]], ...] = (
    check_python,
    check_imports,
    check_generation,
    check_robots,
    check_finishing,
    check_blocking,
    check_saving,
    check_files,
)
