"""The folder to upload: a script and everything it imports, flat, unchanged, and checked.

The testbed takes flat files only.  A script that imports packages (ours, or the user's) is laid
flat like this: the submodules ``package/module.py`` become ``module.py``, byte for byte, and the
package itself becomes one module ``package.py``, its ``__init__.py`` with a few lines added that
make it a package whose folder is the one it lies in::

    __path__ = [os.path.dirname(os.path.abspath(__file__))]

so that ``package.module`` is found beside it, and relative imports work.  The script itself is
not changed.  What cannot be laid flat is an error that says so: two modules of one name, a name
that would hide one of Python's or of the testbed's, a library that the testbed has not, a data
file whose ending is not accepted.

The same input gives the same bytes.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from pathlib import Path

from posflock_robotarium.flocking.errors import OutputError
from posflock_robotarium.submission.instructions import INSTRUCTIONS, instructions
from posflock_robotarium.submission.manifest import (
    LARGEST_FILE,
    MANIFEST,
    read_manifest,
)
from posflock_robotarium.submission.upload_folder import Bundle
from posflock_robotarium.submission.upload_names import (
    BundleError,
    hidden_by,
    require_upload_names,
)
from posflock_robotarium.verify.files import files_read
from posflock_robotarium.verify.source import Source
from rps_compat import testbed
from rps_compat.bounded_files import read_bounded
from rps_compat.scripts import import_graph, libraries
from rps_compat.scripts.interpretation import read_program
from rps_compat.scripts.source import read_script
from rps_compat.scripts.uses import uses_in
from rps_compat.whole_files import atomic_folder, remove_drafts, write_whole

_AS_PACKAGE = """\
# Added by `posflock bundle`: this module is a package whose submodules lie beside it.
__path__ = [__import__("os").path.dirname(__import__("os").path.abspath(__file__))]
__package__ = __name__
__spec__.submodule_search_locations = __path__
"""


def bundle(
    script: Path | str,
    folder: Path | str,
    *,
    data: Sequence[Path] = (),
    search: Sequence[Path] = (),
    robots: int | None = None,
    run_seconds: float | None = None,
    largest: int | None = None,
) -> Bundle:
    """Lay `script` and all it needs flat into `folder`.

    Parameters
    ----------
    script : path
        The main file.
    folder : path
        Where to write: a new or empty folder, or an earlier bundle, which is replaced.
    data : sequence of Path
        Files to take along besides those that the source shows to be read.
    search : sequence of Path
        Further folders with local modules.
    robots : int, optional
        Number of robots, for the instructions.
    run_seconds : float, optional
        How long the script runs, for the instructions.
    largest : int, optional
        Bytes that the upload may have.

    Raises
    ------
    BundleError
        What cannot be laid flat, and the way out.
    ScriptError
        Where a file cannot be read or is not Python.
    OutputError
        Where `folder` cannot be written, or holds something else.
    """
    script, folder = Path(script), Path(folder)
    if script.suffix.lower() != ".py" and script.is_file():
        raise BundleError(f"{script}: the main file must end in .py; rename it")
    found = import_graph.trace(script, search)
    _require_complete(found)
    files = _flat_modules(script, found)
    for path in [*_data(script, found, search), *(Path(extra) for extra in data)]:
        _add_data(files, path)
    require_upload_names(files)
    total = sum(map(len, files.values()))
    if largest is not None and total > largest:
        raise BundleError(
            f"the upload has {total} bytes, but {largest} are allowed; the largest file is"
            f" {max(files, key=lambda name: len(files[name]))}"
        )
    from posflock_robotarium.verify.initial_drive_time import predicted_drive
    from posflock_robotarium.verify.timing import recommended_duration

    duration = None
    if run_seconds is not None and robots is not None:
        duration = recommended_duration(run_seconds, predicted_drive(robots))
    warnings = tuple(_warnings(script, found))
    ready = Bundle(folder, script.name, files, found.left_out, robots, duration, warnings)
    _write(ready)
    return ready


def _require_complete(found: import_graph.Trace) -> None:
    for missing in found.missing:
        statement = missing.statement
        where = f"{missing.wanted_by.name}, line {statement.line}"
        if statement.top == libraries.STAND_IN:
            raise BundleError(
                f"{where}: imports {statement.module}, which stands in for rps on this machine"
                " only; import rps, and rps_compat in `except ImportError`"
            )
        instead = libraries.ABSENT.get(statement.top, "do without it, or upload its source files")
        if statement.top in libraries.ABSENT or missing.installed_here:
            raise BundleError(
                f"{where}: imports {statement.top}, which the testbed has not; {instead}"
            )
        raise BundleError(
            f"{where}: imports {statement.module}, which is neither beside the script nor on the"
            f" testbed; put {statement.top}.py beside {found.script.name}, or correct the name"
        )


def _warnings(script: Path, found: import_graph.Trace) -> Iterator[str]:
    """Yield what stops the uploaded files on the testbed, which runs generation 2 of the API."""
    if libraries.SIMULATOR not in found.libraries:
        yield f"{script.name} never imports {libraries.SIMULATOR}: no robot would move"
    theirs = [local.path for local in found.locals if not import_graph.is_ours(local.name)]
    seen, told = set(), set()
    for path in [script.resolve(), *theirs]:
        if path in seen:  # with what imports it
            continue
        program = read_program(path)
        seen |= {module.script.path for module in program.modules}
        for use in uses_in(program):
            name = use.module.script.path.name
            if use.stops(2) and not use.follows and (name, use.what) not in told:
                told.add((name, use.what))
                yield f"{name}, line {use.line}: {use.what}; {use.remedy(2)}"


def _flat_modules(script: Path, found: import_graph.Trace) -> dict[str, bytes]:
    """Return the flat files of script and modules, or raise where a name cannot stand."""
    files = {script.name: script.read_bytes()}
    owners = {script.name.lower(): f"the main file {script.name}"}
    if script.name.lower() != "main.py":
        # The testbed runs the main file under this name.
        owners["main.py"] = "the main file, which the testbed runs as main.py"
    packages = {local.name for local in found.locals if local.is_package}
    modules = [(local.name, local.path) for local in found.locals]
    parts = [name.split(".") for name, _ in modules]
    above = {".".join(names[:k]) for names in parts for k in range(1, len(names))}
    without_file = above - packages
    for name, path in [*modules, *((name, None) for name in sorted(without_file))]:
        flat = name.rpartition(".")[2] + ".py"
        hidden = libraries.shadowed_by(flat[:-3])
        if hidden:
            raise BundleError(
                f"{name} ({path or 'a folder'}) would lie flat as {flat} and hide {hidden};"
                f" rename the module, for example to {_other_name(name)}.py"
            )
        if flat.lower() in owners:
            raise BundleError(
                f"{name} ({path or 'a folder'}) and {owners[flat.lower()]} would both be {flat};"
                " rename one of them: uploads are flat"
            )
        owners[flat.lower()] = f"{name} ({path or 'a folder'})"
        is_package = name in packages or path is None
        content = b"" if path is None else path.read_bytes()
        files[flat] = as_package(content) if is_package else content
    return files


def _other_name(name: str) -> str:
    parts = name.split(".")
    return "_".join(parts[-2:]) if len(parts) > 1 else f"my_{name}"


def as_package(source: bytes) -> bytes:
    """Return an ``__init__.py`` as one module that is a package lying flat.

    The added lines come after the docstring and ``from __future__``, where they must.

    Parameters
    ----------
    source : bytes
        The file's text.
    """
    tree = ast.parse(source)
    after = 0
    for k, node in enumerate(tree.body):
        is_docstring = (
            k == 0 and isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        )
        is_future = isinstance(node, ast.ImportFrom) and node.module == "__future__"
        if not (is_docstring or is_future):
            break
        after = node.end_lineno or node.lineno
    lines = source.splitlines(keepends=True)
    head, tail = b"".join(lines[:after]), b"".join(lines[after:])
    if head and not head.endswith(b"\n"):
        head += b"\n"
    return head + (b"\n" if head else b"") + _AS_PACKAGE.encode() + tail


def _data(script: Path, found: import_graph.Trace, search: Sequence[Path]) -> list[Path]:
    """Return the data files that script and plain local modules read."""
    home = script.resolve().parent
    sources = [script] + [local.path for local in found.locals if "." not in local.name]
    out = []
    for path in sources:
        source = Source(read_script(path), search=tuple(search))
        for call, name in files_read(source):
            if Path(name).is_absolute() or len(Path(name).parts) > 1:
                raise BundleError(
                    f"{path.name}, line {call.lineno}: reads {name}, but uploads are flat; put it"
                    f" beside the script and read {Path(name).name!r}"
                )
            if (home / name).is_file():
                out.append(home / name)
            elif not _is_written(source.script.text, name):
                raise BundleError(
                    f"{path.name}, line {call.lineno}: reads {name}, which is not beside the script"
                )
    return out


def _is_written(text: str, name: str) -> bool:
    """Whether a file that is read and not there may be one that the script writes first."""
    return text.count(Path(name).stem) > 1


def _add_data(files: dict[str, bytes], path: Path) -> None:
    if path.suffix.lower() not in testbed.ENDINGS:
        raise BundleError(
            f"{path}: files that end in {path.suffix or 'nothing'} cannot be uploaded; accepted"
            f" are {' '.join(testbed.ENDINGS)}"
        )
    try:
        content = read_bounded(path, LARGEST_FILE)
    except OSError as error:
        raise BundleError(f"{path}: cannot be read ({error.strerror or error})") from error
    hidden = hidden_by(path.name)
    if hidden and path.name not in files:
        raise BundleError(f"{path}: would lie beside the script and hide {hidden}; rename it")
    if files.setdefault(path.name, content) != content:
        raise BundleError(f"two different files would be called {path.name}; rename one of them")


def _write(ready: Bundle) -> None:
    """Build the folder beside its place, and put it there: an earlier one stays until then."""
    _require_replaceable(ready.folder)
    with atomic_folder(ready.folder) as folder:
        for name, content in ready.files.items():
            write_whole(folder / name, content)
        write_whole(folder / INSTRUCTIONS, instructions(ready))
        write_whole(folder / MANIFEST, ready.manifest.text())


def _require_replaceable(folder: Path) -> None:
    """Refuse a folder that holds anything but an earlier bundle."""
    if not folder.exists():
        return
    if not folder.is_dir():
        raise OutputError(f"{folder} is a file; choose a new folder")
    remove_drafts(folder)
    there = {path.name for path in folder.iterdir()}
    known = {MANIFEST, INSTRUCTIONS, "__pycache__"}
    if MANIFEST in there:
        known |= set(read_manifest(folder).files)
    strange = there if there and MANIFEST not in there else there - known
    if strange:
        raise OutputError(
            f"{folder} holds other files ({', '.join(sorted(strange)[:4])}); choose a new"
            " folder, or empty it"
        )
