"""What a script imports, found without running it: every import, and the files behind it.

The testbed takes one main file and what lies flat beside it, so two questions must be answered
before an upload: which of a script's imports are the user's own files (or ours), and which are
libraries that the testbed has or lacks.  :func:`trace` walks all ``import`` statements, also
those inside functions, and calls like ``import_module("name")``, and follows into every file
that is not part of an installed library of the testbed.

Three kinds of import are not followed: those under ``if TYPE_CHECKING``, which never run; the
fallbacks in ``except ImportError`` of something that the testbed has, which never run there; and
what a package imports inside a function and needs a library that the testbed lacks, such as a
choice of several solvers.  What is installed on this machine does not matter for that.
"""

from __future__ import annotations

import ast
import contextlib
import importlib.machinery
import importlib.util
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rps_compat.scripts import libraries
from rps_compat.scripts.guards import branch_taken, catches_import_error
from rps_compat.scripts.source import read_script

_OURS = ("posflock_robotarium", "barrier_certificates")


@dataclass(frozen=True)
class Import:
    """One imported module, as written at one place.

    Attributes
    ----------
    module : str
        Absolute dotted name.
    names : tuple of str
        What is taken from it, ``("*",)`` for a star, empty for a plain import.
    line : int
        Where.
    guarded : bool
        Whether an ``except ImportError`` catches its absence.
    relative : bool
        Whether it was written with leading dots.
    lazy : bool
        Whether it stands in a function, and runs only if that is called.
    """

    module: str
    names: tuple[str, ...]
    line: int
    guarded: bool = False
    relative: bool = False
    lazy: bool = False

    @property
    def top(self) -> str:
        """First part of the dotted name."""
        return self.module.partition(".")[0]


@dataclass(frozen=True)
class Local:
    """A file of the user's, or of ours, that a script needs beside it.

    Attributes
    ----------
    name : str
        Dotted name under which it is imported.
    path : Path
        Where it lies here.
    is_package : bool
        Whether it is an ``__init__.py``; a namespace package has no file and is not one.
    wanted_by, line
        The file and line of the first import that asked for it.
    """

    name: str
    path: Path
    is_package: bool
    wanted_by: Path
    line: int


@dataclass(frozen=True)
class Missing:
    """An import that finds nothing the testbed has, and no local file either.

    Attributes
    ----------
    statement : Import
        What was asked for.
    wanted_by : Path
        By which file.
    installed_here : bool
        Whether this machine has it as an installed library.
    """

    statement: Import
    wanted_by: Path
    installed_here: bool


@dataclass
class Trace:
    """Everything that a script imports.

    Attributes
    ----------
    script : Path
        Where it started.
    locals : list of Local
        Files to upload beside the script, in the order in which they were met.
    libraries : set of str
        Top-level names that the testbed has.
    missing : list of Missing
        What it has not, first mention each; those guarded by ``except ImportError`` are left out.
    left_out : dict
        Modules that a package offers but that cannot work there → the library they need.
    """

    script: Path
    locals: list[Local] = field(default_factory=list)
    libraries: set[str] = field(default_factory=set)
    missing: list[Missing] = field(default_factory=list)
    left_out: dict[str, str] = field(default_factory=dict)


def is_ours(module: str) -> bool:
    """Return whether a module belongs to this project rather than to the user.

    Parameters
    ----------
    module : str
        Dotted name of the module.
    """
    return module.partition(".")[0] in _OURS


def imports(tree: ast.Module, package: str = "") -> list[Import]:
    """Return the imports that can run on the testbed, in the order of the text.

    Parameters
    ----------
    tree : ast.Module
        Of a file.
    package : str
        The package the file belongs to, for relative imports; empty for a script.
    """
    return list(_walk(tree.body, package))


def trace(script: Path, search: Sequence[Path] = ()) -> Trace:
    """Follow all imports of `script`.

    Parameters
    ----------
    script : Path
        The main file.
    search : sequence of Path
        Folders to look for modules in after the script's own and before ``sys.path``.

    Raises
    ------
    ScriptError
        The script, or a file it imports, cannot be read.
    UnreadableError
        One of them is not Python.
    """
    script = Path(script).resolve()
    folders = [script.parent, *(Path(folder).resolve() for folder in search)]
    found = Trace(script)
    seen: set[tuple[str, Path]] = set()
    refused: set[str] = set()
    queue: list[tuple[Path, str]] = [(script, "")]
    while queue:
        path, package = queue.pop(0)
        for statement in imports(read_script(path).tree, package):
            if libraries.is_available(statement.top) and not _beside(statement.top, folders[0]):
                found.libraries.add(statement.top)
                continue
            if statement.top == libraries.STAND_IN:
                if not statement.guarded and statement.module not in refused:
                    refused.add(statement.module)
                    found.missing.append(Missing(statement, path, installed_here=True))
                continue
            # Our own modules mean our own, whatever lies beside the script.
            files = list(_files(statement, [] if is_ours(package) else folders))
            if not files and not statement.guarded and statement.top not in refused:
                refused.add(statement.top)
                here = _spec(statement.top) is not None
                found.missing.append(Missing(statement, path, installed_here=here))
            for name, file, is_package in files:
                if (name, file) in seen:
                    continue
                if statement.lazy and package and not is_package:
                    absent = _absent_library(read_script(file).tree, folders)
                    if absent:
                        found.left_out[name] = absent
                        continue
                seen.add((name, file))
                found.locals.append(Local(name, file, is_package, path, statement.line))
                queue.append((file, name if is_package else name.rpartition(".")[0]))
    return found


def _walk(
    body: Sequence[ast.stmt], package: str, guarded: bool = False, lazy: bool = False
) -> Iterator[Import]:
    for node in body:
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield Import(alias.name, (), node.lineno, guarded, lazy=lazy)
        elif isinstance(node, ast.ImportFrom):
            names = tuple(alias.name for alias in node.names)
            module = _absolute(node, package)
            yield Import(module, names, node.lineno, guarded, node.level > 0, lazy)
        elif isinstance(node, ast.If) and branch_taken(node.test) is not None:
            taken = node.body if branch_taken(node.test) else node.orelse
            yield from _walk(taken, package, guarded, lazy)
        elif isinstance(node, ast.Try):
            catches = any(catches_import_error(handler) for handler in node.handlers)
            yield from _walk(node.body, package, guarded or catches, lazy)
            if not (catches and _always_there(node.body, package)):
                for handler in node.handlers:
                    yield from _walk(handler.body, package, guarded, lazy)
            yield from _walk([*node.orelse, *node.finalbody], package, guarded, lazy)
        else:
            for module in _called(node, package):
                yield Import(module, (), node.lineno, guarded, lazy=lazy)
            inside = isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
            for _, value in ast.iter_fields(node):
                if isinstance(value, list):
                    statements = [entry for entry in value if isinstance(entry, ast.stmt)]
                    for entry in value:
                        if isinstance(entry, ast.match_case):
                            statements += entry.body
                    yield from _walk(statements, package, guarded, lazy or inside)


def _called(node: ast.stmt, package: str) -> Iterator[str]:
    """Yield what a statement imports by ``import_module("name")`` or ``__import__("name")``."""
    parts = (ast.stmt, ast.excepthandler, ast.match_case)
    for part in ast.iter_child_nodes(node):
        for inner in () if isinstance(part, parts) else ast.walk(part):
            if not isinstance(inner, ast.Call) or not inner.args:
                continue
            name = getattr(inner.func, "attr", getattr(inner.func, "id", ""))
            module = getattr(inner.args[0], "value", None)
            if name not in ("import_module", "__import__") or not isinstance(module, str):
                continue
            if module.startswith("."):
                module = _relative(inner, module, package)
            if module:
                yield module


def _relative(call: ast.Call, module: str, package: str) -> str:
    """Resolve ``import_module(".name", "package")``; empty where the package is not plain."""
    named = [keyword.value for keyword in call.keywords if keyword.arg == "package"]
    for anchor in (*call.args[1:2], *named):
        if isinstance(anchor, ast.Name) and anchor.id == "__package__":
            base = package
        else:
            base = str(getattr(anchor, "value", ""))
        with contextlib.suppress(ImportError):
            return importlib.util.resolve_name(module, base)
    return ""


def _absent_library(tree: ast.Module, folders: Sequence[Path]) -> str | None:
    """Return what a module imports that neither the testbed has nor a local file brings."""
    for statement in imports(tree):
        top = statement.top
        if statement.relative or statement.guarded or libraries.is_available(top):
            continue
        if top not in _OURS and not any(_files(statement, folders)):
            return top
    return None


def _always_there(body: Sequence[ast.stmt], package: str) -> bool:
    """Whether all that a ``try`` imports is on the testbed, so that its handlers never run."""
    return all(libraries.is_available(statement.top) for statement in _walk(body, package))


def _absolute(node: ast.ImportFrom, package: str) -> str:
    if not node.level:
        return node.module or ""
    parts = package.split(".") if package else []
    base = parts[: len(parts) - (node.level - 1)]
    return ".".join([*base, *([node.module] if node.module else [])])


def _beside(top: str, folder: Path) -> bool:
    """Whether a module or package of the user's hides a library of that name.

    A package ``rps`` beside the script is a copy of the simulator, which stays here.
    """
    is_package = (folder / top / "__init__.py").is_file() and top != libraries.SIMULATOR
    return is_package or (folder / f"{top}.py").is_file()


def _files(statement: Import, folders: Sequence[Path]) -> Iterator[tuple[str, Path, bool]]:
    """Yield the local files that an import runs: packages on the way, the module, submodules."""
    parts = statement.module.split(".")
    names = [".".join(parts[: k + 1]) for k in range(len(parts))]
    names += [f"{statement.module}.{name}" for name in statement.names if name != "*"]
    if not parts[0]:
        return
    where: list[Path] = _homes(parts[0], folders)
    places: dict[str, list[Path]] = {"": where}
    for name in names:
        parent, _, last = name.rpartition(".")
        for folder in places.get(parent, []):
            if (folder / last / "__init__.py").is_file():
                yield name, folder / last / "__init__.py", True
                places[name] = [folder / last]
                break
            if (folder / f"{last}.py").is_file():
                yield name, folder / f"{last}.py", False
                break
            if (folder / last).is_dir() and any((folder / last).rglob("*.py")):
                places[name] = [folder / last]
                break


def _homes(top: str, folders: Sequence[Path]) -> list[Path]:
    """Return the folders in which a top-level module may be taken for the user's own file."""
    homes = list(folders)
    if top in _OURS or not _is_installed(top):
        spec = _spec(top)
        if spec is not None and spec.origin and spec.origin.endswith(".py"):
            file = Path(spec.origin)
            homes.append(file.parent.parent if file.name == "__init__.py" else file.parent)
    return homes


def _is_installed(top: str) -> bool:
    """Whether a module comes from an installed library rather than from somebody's folder."""
    spec = _spec(top)
    if spec is None or spec.origin is None or not spec.origin.endswith(".py"):
        return spec is not None
    return bool({"site-packages", "dist-packages"} & set(Path(spec.origin).parts))


def _spec(top: str) -> importlib.machinery.ModuleSpec | None:
    if top in sys.builtin_module_names:
        return None
    try:
        return importlib.util.find_spec(top)
    except (ImportError, ValueError):
        return None
