"""Files that a script reads and writes, as far as its source tells."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import PurePath

from posflock_robotarium.verify.constants import SCRIPT, constant
from posflock_robotarium.verify.findings import Code, Finding, Verdict
from posflock_robotarium.verify.source import Source
from rps_compat import testbed

#: What numpy's and pandas' readers fetch from the network.
_URL = re.compile(r"(?:https?|ftp)://", re.I)
#: Exceptions whose handler is prepared for a file that is not there.
_NO_FILE = {"FileNotFoundError", "OSError", "IOError", "Exception", "BaseException"}
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


def check_files(source: Source) -> Iterator[Finding]:
    """Check the files it reads: there, flat, with an ending that may be uploaded.

    Parameters
    ----------
    source : Source
        What the checks know of the script.
    """
    written = {path for call in source.calls if (path := path_written(source, call)) is not None}
    for call, path in files_read(source):
        line = call.lineno
        if path in written or (call.args and not path):
            continue
        pure = PurePath(path)
        if _URL.match(path):
            yield Finding(
                Code.NETWORK,
                Verdict.RISK,
                f"reads {path}, and the testbed has no network",
                f"fetch it, put it beside the script and read {pure.name!r}",
                line=line,
            )
        elif pure.is_absolute() or len(pure.parts) > 1:
            yield Finding(
                Code.FILE_IN_FOLDER,
                Verdict.FAIL,
                f"reads {path}, but uploads are flat: there are no folders beside the script",
                f"put {pure.name} beside the script and read {pure.name!r}",
                line=line,
            )
        elif pure.suffix.lower() not in testbed.ENDINGS:
            yield Finding(
                Code.FILE_ENDING,
                Verdict.FAIL,
                f"reads {path}, but files that end in {pure.suffix or 'nothing'} cannot be"
                " uploaded",
                f"use one of {' '.join(testbed.ENDINGS)}; .npy holds any array",
                line=line,
            )
        elif not (source.path.parent / path).is_file():
            yield Finding(
                Code.FILE_MISSING,
                Verdict.FAIL,
                f"reads {path}, which is not beside the script",
                f"put {path} into {source.path.resolve().parent}",
                line=line,
            )


def files_read(source: Source) -> Iterator[tuple[ast.Call, str]]:
    """Yield the calls that read a file whose path is known, with the path.

    A file that the script is prepared to miss counts only where it is there.

    Parameters
    ----------
    source : Source
        What the checks know of the script.
    """
    prepared = _prepared_for_absence(source.tree)
    for call in source.calls:
        name = source.called(call)
        method = call.func.attr if isinstance(call.func, ast.Attribute) else ""
        if (name in _READERS and not _makes_memmap(source, call)) or (
            name == "open" and _mode(source, call)[:1] == "r"
        ):
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


def writes(source: Source, call: ast.Call) -> bool:
    """Return whether a call writes a file.

    Parameters
    ----------
    source : Source
        What the checks know of the script.
    call : ast.Call
        One of the script's calls.
    """
    name = source.called(call)
    opens = name == "open" or _opens_path(source, call)
    if (
        name in _WRITERS
        or _makes_memmap(source, call)
        or (opens and _mode(source, call)[:1] in ("w", "a", "x"))
    ):
        return True
    method = call.func.attr if isinstance(call.func, ast.Attribute) else ""
    return method in _WRITING_METHODS


def path_written(source: Source, call: ast.Call) -> str | None:
    """Return the path that a call writes to, None where it writes none or the source hides it.

    Parameters
    ----------
    source : Source
        What the checks know of the script.
    call : ast.Call
        One of the script's calls.
    """
    if not writes(source, call):
        return None
    of_path = _opens_path(source, call) or not _is_of_a_name(call.func)
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


def _is_of_a_name(function: ast.expr) -> bool:
    """Whether what is called begins with a name, as ``fig.savefig`` does."""
    while isinstance(function, ast.Attribute):
        function = function.value
    return isinstance(function, ast.Name)


def _makes_memmap(source: Source, call: ast.Call) -> bool:
    """``numpy.memmap(…, mode="w+")``, which makes the file that it maps."""
    given = [k.value for k in call.keywords if k.arg == "mode"] or call.args[2:3]
    return (
        source.called(call) == "numpy.memmap"
        and bool(given)
        and constant(given[0], source.names) in ("w+", "write")
    )


def _opens_path(source: Source, call: ast.Call) -> bool:
    """``path.open()``, of a path that is known."""
    return (
        isinstance(call.func, ast.Attribute)
        and call.func.attr == "open"
        and isinstance(constant(call.func.value, source.names), PurePath)
    )


def _mode(source: Source, call: ast.Call) -> str:
    first = 0 if _opens_path(source, call) else 1
    given = [k.value for k in call.keywords if k.arg == "mode"] or call.args[first : first + 1]
    mode = constant(given[0], source.names) if given else "r"
    return mode.replace("b", "").replace("t", "") if isinstance(mode, str) else "?"


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
            and any(catches(handler, _NO_FILE) for handler in node.handlers)
        ) or (
            isinstance(node, ast.With)
            and any(_suppresses(item.context_expr) for item in node.items)
        ):
            bodies = list(node.body)
        for body in bodies:
            found |= set(ast.walk(body))
    return found


def _suppresses(manager: ast.expr) -> bool:
    """Whether a block is ``contextlib.suppress(…)``, however it was imported."""
    return isinstance(manager, ast.Call) and _last_name(manager.func) == "suppress"


def _last_name(function: ast.expr) -> str:
    """Return the name by which a function is called, without what is before the dot."""
    return str(getattr(function, "attr", getattr(function, "id", "")))


def _asks_for_a_file(test: ast.expr) -> bool:
    return any(
        isinstance(node, ast.Call) and _last_name(node.func) in ("exists", "is_file", "isfile")
        for node in ast.walk(test)
    )


def catches(handler: ast.ExceptHandler, wanted: set[str]) -> bool:
    """Return whether a handler catches one of some exceptions.

    Parameters
    ----------
    handler : ast.ExceptHandler
        An ``except`` with what it catches.
    wanted : set of str
        Names of the exceptions.
    """
    kinds = handler.type.elts if isinstance(handler.type, ast.Tuple) else [handler.type]
    names = {kind.id for kind in kinds if isinstance(kind, ast.Name)}
    return handler.type is None or bool(names & wanted)
