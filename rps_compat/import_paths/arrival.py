"""Bring ``rps_compat`` into a process whose script imports ``rps``, and give it generation `api`.

Nothing of the script's may be taken for ours, or for a library that we need. What looks after that
is imported before our package itself runs: the package is there without having run yet.
"""

import os
import sys
from _frozen_importlib import module_from_spec
from _frozen_importlib_external import PathFinder


def arrive(api: int) -> None:
    """Let ``import rps`` mean generation `api`, whatever lies beside the script."""
    package = sys.modules.get("rps_compat")
    runs = hasattr(package, "install")
    if package is None or not runs:
        spec = PathFinder.find_spec("rps_compat", [__file__.rpartition("rps_compat")[0]])
        assert spec is not None
        package = sys.modules["rps_compat"] = module_from_spec(spec)
    from rps_compat.own_imports import keep_apart

    names = keep_apart()
    if not runs:
        assert package.__spec__ is not None
        assert package.__spec__.loader is not None
        package.__spec__.loader.exec_module(package)
    package.install(api=api)
    __import__("rps")
    from rps_compat.children import VARIABLE

    if VARIABLE in os.environ:
        from rps_compat.children.arrival import join_run

        join_run()
    elif names.files:
        from rps_compat.process_state import hiding_notes

        for note in hiding_notes(names):
            print(f"rps: note: {note}", file=sys.stderr)


arrive(api)  # type: ignore[name-defined]  # noqa: F821 - given by who runs this file
