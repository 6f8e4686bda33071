"""What a script expects of its process, and what the process gets back when it ends.

The script is alone in the world, as far as it can see: it has its own folder, its own arguments,
``rps`` of its generation and the random numbers of its seed. A file beside it may be called like
one of our modules or of a library's (:mod:`rps_compat.own_imports`); on the testbed, where all
files lie in one folder, that would hurt, so it is noted.
"""

import contextlib
import os
import random
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from rps_compat.generations import Generation
from rps_compat.install import install, installed, uninstall
from rps_compat.own_imports import HiddenNames, KeptApart
from rps_compat.own_imports.whose import is_environments_module
from rps_compat.repeatable import seed_global_generators
from rps_compat.scripts.libraries import shadowed_by

#: As what children of `multiprocessing` know the main module, and send their results by its names.
_MAIN_OF_CHILDREN = "__mp_main__"
#: Files that hide something beyond this many are counted only.
TOLD = 5


@contextlib.contextmanager
def process_state(
    script: Path,
    words: Sequence[str],
    generation: Generation,
    seed: int | None,
    folders: Sequence[str] = (),
    keeps_apart: bool = True,
) -> Iterator[HiddenNames | None]:
    """Be where `script` expects to be within the ``with`` block; leave the process as it was.

    Parameters
    ----------
    script
        An absolute path.
    words
        The script as it is called, and its own arguments.
    generation
        Generation of ``rps``.
    seed
        Of Python's and numpy's global generators; None leaves them as they are.
    folders
        Further ones to import from.
    keeps_apart
        Whether files of the script are kept from hiding the environment's modules; without, the
        block is given None.
    """
    folder, argv, path = Path.cwd(), sys.argv, list(sys.path)
    bytecode, before, modules = sys.dont_write_bytecode, installed(), set(sys.modules)
    randomness = random.getstate(), np.random.get_state()  # noqa: NPY002
    main = sys.modules.get(_MAIN_OF_CHILDREN)
    if main is not None:  # it was set when somebody imported multiprocessing: not for the script
        sys.modules[_MAIN_OF_CHILDREN] = _MainNow(_MAIN_OF_CHILDREN)
    others = _set_aside(script.parent)
    os.chdir(script.parent)
    sys.argv = list(words)
    sys.path[:0] = [str(script.parent), *folders]
    sys.dont_write_bytecode = True  # the script's folder is not ours to write to
    install(generation)
    if seed is not None:
        seed_global_generators(seed)
    try:
        apart = KeptApart(str(script.parent)) if keeps_apart else contextlib.nullcontext()
        with apart as names:
            yield names
    finally:
        os.chdir(folder)
        sys.argv, sys.path[:], sys.dont_write_bytecode = argv, path, bytecode
        random.setstate(randomness[0])
        np.random.set_state(randomness[1])  # noqa: NPY002
        uninstall() if before is None else install(before)
        if main is not None:
            sys.modules[_MAIN_OF_CHILDREN] = main
        _forget_modules_of(script.parent, modules)
        sys.modules.update(others)


class _MainNow(ModuleType):
    """Has the names of whatever is the main module when it is asked."""

    def __getattr__(self, name: str) -> Any:
        return getattr(sys.modules["__main__"], name)


def _set_aside(folder: Path) -> dict[str, ModuleType]:
    """Take away modules of other folders that are called like files in `folder`; return them.

    The environment's own stay: :class:`KeptApart` gives them to whoever means them.
    """
    beside = {path.stem for path in folder.iterdir() if path.suffix == ".py" or path.is_dir()}
    found = {}
    for name, module in list(sys.modules.items()):
        source = getattr(module, "__file__", None)
        if (
            name.partition(".")[0] in beside
            and source
            and not Path(source).is_relative_to(folder)
            and not is_environments_module(module)
        ):
            found[name] = sys.modules.pop(name)
    return found


def _forget_modules_of(folder: Path, known: set[str]) -> None:
    """Drop modules that the script imported from its own `folder`: the next script has its own."""
    for name in set(sys.modules) - known:
        module = sys.modules[name]
        source = getattr(module, "__file__", None)
        if source and Path(source).is_relative_to(folder) and not is_environments_module(module):
            del sys.modules[name]


def hiding_notes(names: HiddenNames | None) -> list[str]:
    """Note what of Python's or of the testbed's the script's files hide, where anybody needs it.

    Parameters
    ----------
    names : HiddenNames or None
        What the files beside the script claim; None where nobody looked.
    """
    found: list[str] = []
    if names is None:
        return found
    for name in sorted(names.claimed | names.asked):
        hidden = shadowed_by(name)
        if hidden:
            file = Path(names.files[name])
            what = f"{file.parent.name}/" if file.stem == "__init__" else file.name
            found.append(f"{what} beside the script hides {hidden}")
    if len(found) > TOLD:
        rest = len(found) - TOLD
        found[TOLD:] = [f"{rest} more files beside the script hide modules and libraries of Python"]
    return [f"{what}; {_HIDING}" for what in found]


_HIDING = (
    "here each gets its own, but on the testbed, where all files lie in one folder, whoever needs "
    "that gets this file"
)
