"""What a script's source says about its chances, without running it.

Each check is one function that takes a :class:`Source` and yields findings; :data:`CHECKS` lists
them.  They read the syntax tree, so a name in a comment or a string is no finding, and they give
the line.  A check speaks only when it is sure: what cannot be read off the source is left to the
trial runs.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from pathlib import Path

from posflock_robotarium.verify.constants import constant
from posflock_robotarium.verify.files import check_files
from posflock_robotarium.verify.findings import Code, Finding, Verdict, too_many_robots
from posflock_robotarium.verify.saving import check_saving
from posflock_robotarium.verify.source import Source
from rps_compat import testbed
from rps_compat.errors import ScriptError
from rps_compat.scripts import import_graph, libraries
from rps_compat.scripts.api import ApiName
from rps_compat.scripts.changes import Change, Kind
from rps_compat.scripts.source import UnreadableError, read_script
from rps_compat.scripts.uses import OLDER_WAY, Absent, Use

_FINISHING = ("debug", "call_at_scripts_end")


_BLOCKING = {
    "input": "waits for a key",
    "builtins.input": "waits for a key",
    "breakpoint": "waits for a debugger",
    "pdb.set_trace": "waits for a debugger",
    "getpass.getpass": "waits for a password",
    "matplotlib.pyplot.show": "waits until its window is closed",
    "matplotlib.pyplot.waitforbuttonpress": "waits for a key",
    "matplotlib.pyplot.ginput": "waits for a click",
    "sys.stdin.read": "waits for a line",
    "sys.stdin.readline": "waits for a line",
}


def check_source(
    script: Path, generation: int = 2, search: tuple[Path, ...] = ()
) -> tuple[list[Finding], Source | None]:
    """Return all that a script's source says, and the source itself where it parses.

    Parameters
    ----------
    script : Path
        The script's file.
    generation : int
        Of the API: 1 or 2.
    search : tuple of Path
        Further folders with local modules.

    Raises
    ------
    ScriptError
        Where the file cannot be read.
    """
    try:
        source = Source(read_script(script), generation, search)
    except UnreadableError as error:
        return [_unreadable(error)], None
    findings = [finding for check in CHECKS for finding in check(source)]
    return sorted(findings, key=lambda finding: (finding.file, finding.line or 0)), source


def _unreadable(error: UnreadableError) -> Finding:
    """Tell why Python refuses a source."""
    if error.newer is not None:
        return Finding(Code.NEWER_PYTHON, Verdict.FAIL, error.reason, OLDER_WAY, line=error.line)
    advice = "mend the line; `python -m py_compile` shows the place"
    return Finding(Code.SYNTAX, Verdict.FAIL, error.reason, advice, line=error.line)


# --- Python, libraries and the API -------------------------------------------------------------


def check_names(source: Source) -> Iterator[Finding]:
    """Check names and syntax: the testbed's Python, libraries and generation have them.

    Parameters
    ----------
    source : Source
        What the checks know of the script.
    """
    for use in source.uses:
        if use.follows or use.ready or isinstance(use.entry, Absent):
            continue  # imports of absent libraries are told of with all others
        if not use.matters(source.generation):
            if isinstance(use.entry, Change):  # newer versions lack it
                yield _named(source, use, Verdict.NOTE)
            continue
        yield _named(source, use, Verdict.FAIL)


def _named(source: Source, use: Use, verdict: Verdict) -> Finding:
    what = use.what
    if isinstance(use.entry, ApiName):
        code, runs = Code.GENERATION, f"the testbed runs generation {source.generation}"
        what = f"{what}, and {runs}" if use.entry.generations else what
    elif not isinstance(use.entry, Change) or use.entry.is_pythons_newer:
        code = Code.NEWER_PYTHON
    elif use.entry.path.partition(".")[0] == "numpy" and use.entry.kind is Kind.GONE:
        code = Code.REMOVED_FROM_NUMPY
    else:
        code = {
            Kind.GONE: Code.REMOVED_FROM_LIBRARY,
            Kind.NEWER: Code.NEWER_LIBRARY,
            Kind.LATER: Code.REMOVED_LATER,
        }[use.entry.kind]
    file = use.module.script.path.name if use.module.name else ""
    advice = use.remedy(source.generation)
    return Finding(code, verdict, what, advice, line=use.line, file=file)


def check_imports(source: Source) -> Iterator[Finding]:
    """Check imports: libraries that the testbed has, files to be uploaded, hidden names.

    Parameters
    ----------
    source : Source
        What the checks know of the script.
    """
    try:
        trace = source.trace
    except ScriptError as error:
        yield Finding(Code.SYNTAX, Verdict.FAIL, str(error), "mend the imported file")
        return
    for missing in trace.missing:
        if missing.statement.top in libraries.NEWER_MODULES:
            continue  # told of as newer than Python 3.10
        yield _missing(source, missing)
    paths = {local.name: local.path for local in reversed(trace.locals)}
    for local in trace.locals:
        hidden = libraries.shadowed_by(local.name) if "." not in local.name else None
        if paths[local.name] != local.path:  # of two, the user's is the one that is found there
            yield Finding(
                Code.SHADOWED_NAME,
                Verdict.FAIL,
                f"{local.name}.py beside the script would hide posflock's own {local.name}, which"
                f" {local.wanted_by.name} needs",
                "rename the file beside the script",
            )
        elif hidden and not local.is_package:
            yield Finding(
                Code.SHADOWED_NAME,
                Verdict.FAIL,
                f"{local.path.name} would hide {hidden}",
                "rename the file",
                line=local.line,
                file=_file(source, local.wanted_by),
            )
    newer = libraries.NEWER_MODULES  # this Python's own are no files of the user's
    wanted = [local for local in trace.locals if local.name.partition(".")[0] not in newer]
    if wanted and not any(libraries.shadowed_by(local.name) for local in wanted):
        first = wanted[0]
        names = sorted({local.name.partition(".")[0] for local in wanted})
        yield Finding(
            Code.LOCAL_MODULE,
            Verdict.NOTE,
            f"{len(wanted)} local file{'s' * (len(wanted) > 1)} must be uploaded with"
            f" it: {', '.join(names)}",
            f"`posflock bundle {source.path.name} -o upload` lays them flat",
            line=first.line,
        )


def _missing(source: Source, missing: import_graph.Missing) -> Finding:
    statement = missing.statement

    def fail(code: Code, message: str, advice: str) -> Finding:
        file = _file(source, missing.wanted_by)
        return Finding(code, Verdict.FAIL, message, advice, line=statement.line, file=file)

    if statement.top == libraries.STAND_IN:
        return fail(
            Code.STAND_IN,
            f"{statement.module} stands in for rps on this machine only",
            "import rps, and rps_compat in `except ImportError`",
        )
    if statement.relative:
        return fail(
            Code.MODULE_MISSING,
            f"the relative import of {statement.module or 'its own package'!r} needs a package,"
            " but the main file is none",
            "import it by its plain name",
        )
    if statement.top in libraries.ABSENT:
        return fail(
            Code.LIBRARY_ABSENT,
            f"the testbed has no {statement.top}",
            libraries.ABSENT[statement.top],
        )
    if missing.installed_here:
        return fail(
            Code.LIBRARY_ABSENT,
            f"{statement.top} is not in the testbed's list of libraries",
            "do without it, or put its source files beside the script",
        )
    return fail(
        Code.MODULE_MISSING,
        f"there is no module {statement.module}: neither beside the script nor on the testbed",
        f"put {statement.top}.py beside {source.path.name}, or correct the name",
    )


# --- What it does ------------------------------------------------------------------------------


def check_robots(source: Source) -> Iterator[Finding]:
    """Count the robots asked for.

    Parameters
    ----------
    source : Source
        What the checks know of the script.
    """
    for call in source.calls:
        if not source.constructs(call):
            continue
        given = [k.value for k in call.keywords if k.arg == "number_of_robots"] or call.args[:1]
        number = constant(given[0], source.names) if given else None
        if isinstance(number, (int, float)) and number > testbed.MAX_ROBOTS:
            yield too_many_robots(number, call.lineno)


def check_finishing(source: Source) -> Iterator[Finding]:
    """Look for the call that ends an experiment.

    Parameters
    ----------
    source : Source
        What the checks know of the script.
    """
    made = [call for call in source.calls if source.constructs(call)]
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
            Code.NO_FINISHING_CALL,
            Verdict.RISK,
            f"never calls {right}(), so the run does not end in order and says nothing about its"
            " violations",
            f"end the script with r.{right}()",
            line=made[-1].lineno,
        )


def check_blocking(source: Source) -> Iterator[Finding]:
    """Look for calls that wait for somebody who is not there, and for sleeps.

    Parameters
    ----------
    source : Source
        What the checks know of the script.
    """
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
                Code.BLOCKING_CALL,
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
                    Code.WATCHDOG if long else Code.SLOW_SLEEP,
                    Verdict.RISK,
                    f"sleeps {seconds:g} s in its loop, longer than a step of"
                    f" {testbed.TIME_STEP} s"
                    + (": robots brake after 0.5 s without a command" if long else ""),
                    "remove it: r.step() keeps the time",
                    line=call.lineno,
                    figure=float(seconds),
                    unit="s",
                )


def _file(source: Source, path: Path) -> str:
    return "" if path == source.path.resolve() else path.name


CHECKS: tuple[Callable[[Source], Iterator[Finding]], ...] = (
    check_names,
    check_imports,
    check_robots,
    check_finishing,
    check_blocking,
    check_saving,
    check_files,
)
