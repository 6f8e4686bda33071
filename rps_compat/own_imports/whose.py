"""Whose a file is: the environment's (Python's, installed, ours) or the script's."""

import os
import sys
from _frozen_importlib_external import PathFinder

TYPE_CHECKING = False  # typing's own may be hidden
if TYPE_CHECKING:
    from types import FrameType, ModuleType
    from typing import Any

#: Our packages, wherever the folder they lie in is on ``sys.path``, and even if it is not.
OURS = ("barrier_certificates", "rps_compat", "posflock_robotarium")
#: The folder they lie in.
HOME = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
#: What we use where it is installed.
OPTIONAL = (
    "cvxopt",
    "daqp",
    "distributed",
    "imageio_ffmpeg",
    "mcap",
    "piqp",
    "pyarrow",
    "quadprog",
    "rosbags",
)
_STANDARD = os.path.dirname(os.path.abspath(os.__file__))
_ENVIRONMENT = (_STANDARD, *(os.path.join(HOME, name) for name in OURS))
_INSTALLED = {"site-packages", "dist-packages"}
_IMPORT_SYSTEM = (
    "importlib",
    "_frozen_importlib",
    "rps_compat.own_imports",
    "rps_compat.when_imported",
)

#: Folders of scripts; an installation within one is the environment's all the same.
script_folders: "set[str]" = set()
_known: "dict[str, bool]" = {}


def add_script_folder(folder: str) -> None:
    """Take note that modules in a folder are the script's.

    Parameters
    ----------
    folder : str
        The folder's path.
    """
    if folder not in script_folders:
        script_folders.add(folder)
        _known.clear()


def forget_script_folders(folders: "set[str]") -> None:
    """Take note that modules in some folders are nobody's any more.

    Parameters
    ----------
    folders : set of str
        The folders' paths.
    """
    script_folders.difference_update(folders)
    _known.clear()


def is_environments(file: "str | None") -> bool:
    """Return whether a module's file is the environment's.

    Parameters
    ----------
    file : str or None
        The file or origin; None where the module has none.
    """
    if file is None or file in ("built-in", "frozen") or file.startswith("<frozen "):
        return True
    if file not in _known:
        _known[file] = _find_out(os.path.abspath(file))
    return _known[file]


def _find_out(file: str) -> bool:
    around = [root for root in (*_ENVIRONMENT, *script_folders) if file.startswith(root + os.sep)]
    nearest = max(around, key=len, default="")
    if nearest in _ENVIRONMENT:
        return True
    return bool(_INSTALLED.intersection(file[len(nearest) :].split(os.sep)))


def is_installation(folder: str) -> bool:
    """Whether a folder on ``sys.path`` belongs to the environment.

    Parameters
    ----------
    folder : str
        The folder's path.
    """
    if folder in script_folders:
        return False
    parts = folder.split(os.sep)
    if folder == _STANDARD or folder.startswith(_STANDARD + os.sep) or _INSTALLED & set(parts):
        return True
    return parts[-1].startswith("python") and parts[-1].endswith(".zip")


def is_environments_module(module: "ModuleType") -> bool:
    """Whether a module is the environment's.

    Parameters
    ----------
    module : module
        An imported module, with or without a file.
    """
    origin = getattr(getattr(module, "__spec__", None), "origin", None)
    return is_environments(origin or getattr(module, "__file__", None))


def environments_module(name: str) -> "Any":
    """Return a module of the environment if it is imported, else None.

    Parameters
    ----------
    name : str
        The module's name.
    """
    module = sys.modules.get(name)
    return module if module is not None and is_environments_module(module) else None


def is_environments_code(variables: "dict[str, Any] | None", frame: "FrameType | None") -> bool:
    """Return whether it is code of the environment that runs.

    Code that says nothing of itself, as ``exec`` runs it, is its caller's.

    Parameters
    ----------
    variables : dict or None
        Global variables of the code.
    frame : frame or None
        Where it runs.
    """
    while variables is not None or frame is not None:
        if variables is not None:
            file = variables.get("__file__")
            spec = variables.get("__spec__")
            if file is None and spec is not None:
                file = spec.origin
            if file is not None:
                return is_environments(file)
            if variables.get("__name__") == "__main__":  # of a session, or `python -c`
                return False
        if frame is None:
            break
        name = frame.f_code.co_filename
        if not name.startswith("<") or name.startswith("<frozen "):
            return is_environments(name)
        frame = frame.f_back
        variables = None if frame is None else frame.f_globals
    return False


def is_import_system(frame: "FrameType") -> bool:
    """Return whether a frame is part of the machinery of imports, Python's or ours.

    Parameters
    ----------
    frame : frame
        Where code runs, as ``sys._getframe`` gives it.
    """
    name = frame.f_globals.get("__name__", "")
    return any(name == part or name.startswith(f"{part}.") for part in _IMPORT_SYSTEM)


def asks_for_itself(nobody: bool) -> bool:
    """Return whether the environment's own code asks for the import that is under way.

    To be called by a finder, of whoever asked past the machinery of imports.

    Parameters
    ----------
    nobody : bool
        What holds where there is no code but that machinery.
    """
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and is_import_system(frame):
        frame = frame.f_back
    return nobody if frame is None else is_environments_code(frame.f_globals, frame)


def find_environments(name: str) -> "Any":
    """Find the spec of a top-level module of the environment; None if there is none.

    Parameters
    ----------
    name : str
        The module's name.
    """
    if name in OURS:
        return PathFinder.find_spec(name, [HOME])
    spec = PathFinder.find_spec(name, [e for e in sys.path if is_installation(os.path.abspath(e))])
    if spec is not None and spec.loader is not None:
        return spec
    for finder in sys.meta_path:  # installed as links to their sources
        if getattr(finder, "__module__", "").startswith("__editable__"):
            found = finder.find_spec(name, None, None)
            if found is not None:
                return found
    return spec  # of a package without __init__.py, or None


def modules_in(folder: str) -> "set[str]":
    """Return the names of the modules and packages in a folder, as far as files' names tell.

    Parameters
    ----------
    folder : str
        The folder's path.
    """
    try:
        entries = os.listdir(folder)
    except OSError:  # not there, or a zip file; of that we look for our own names only
        return set(OURS) if os.path.isfile(folder) else set()
    return {entry.partition(".")[0] for entry in entries}
