"""Bring ``rps_compat`` into a process in which it is not, whatever lies beside the script.

Nothing of the script's may be taken for ours, or for a library that we need. What looks after that
(:mod:`rps_compat.own_imports`) is imported before our package itself runs: the package is there
without having run yet. This file is not imported but executed, since its name may be hidden, too.
"""

import os
import sys
from _frozen_importlib import module_from_spec
from _frozen_importlib_external import PathFinder

TYPE_CHECKING = False  # typing's own may be hidden
if TYPE_CHECKING:
    from typing import Any


def keep_apart(folder: "str | None" = None) -> "Any":
    """Keep the script's modules and the environment's apart; our package need not run for that.

    Parameters
    ----------
    folder : str, optional
        Folder of the script; by default that of the process's main file.
    """
    before = sys.modules.get("rps_compat")
    if not hasattr(before, "install"):
        spec = PathFinder.find_spec("rps_compat", [__file__.rpartition("rps_compat")[0]])
        assert spec is not None
        sys.modules["rps_compat"] = module_from_spec(spec)
    from rps_compat import own_imports

    names = own_imports.keep_apart(folder)
    if before is not None and before is not sys.modules["rps_compat"]:
        names.keep_aside(before)
    return names


def arrive(generation: int) -> None:
    """Let ``import rps`` mean a generation in a process whose script has imported it.

    Parameters
    ----------
    generation : int
        Of the API: 1 or 2.
    """
    names = keep_apart()
    _run_package().install(generation=generation)
    __import__("rps")
    from rps_compat.children import VARIABLE

    if VARIABLE in os.environ:
        from rps_compat.children.arrival import join_run

        join_run()
        return
    from rps_compat.bridges import FOR_GOOD, bridge

    bridge(FOR_GOOD)
    if names.files:
        from rps_compat.process_state import hiding_notes

        for note in hiding_notes(names):
            print(f"rps: note: {note}", file=sys.stderr)


def arrive_as_worker() -> None:
    """Join the run whose script lets `multiprocessing` start this process, before anything else."""
    keep_apart(os.getcwd())
    _run_package()
    from rps_compat.children.arrival import join_run

    join_run(as_worker=True)


def _run_package() -> "Any":
    package = sys.modules["rps_compat"]
    if not hasattr(package, "install"):
        assert package.__spec__ is not None
        assert package.__spec__.loader is not None
        package.__spec__.loader.exec_module(package)
    return package
