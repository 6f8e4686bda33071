"""What Python runs first in every process that a script starts while it runs here.

`multiprocessing` imports much before it comes to the script, from the script's folder first; and
what is beside the script, or a copy of the simulator, must be found here as in the script's own
process. Python runs the first ``sitecustomize`` only, so the next one is run from here.
"""

import os
import sys
from _frozen_importlib import module_from_spec
from _frozen_importlib_external import PathFinder, SourceFileLoader

TYPE_CHECKING = False  # typing's own may be hidden
if TYPE_CHECKING:
    from typing import Any

_HERE = os.path.dirname(os.path.abspath(__file__))
_IMPORT_PATHS = os.path.dirname(_HERE)


class RpsFirst:
    """Finds ``rps`` on PYTHONPATH even where a copy of the simulator lies beside the script."""

    def find_spec(self, name: str, path: "Any" = None, target: "Any" = None) -> "Any":
        """Find ``rps``, and nothing else.

        Parameters
        ----------
        name : str
            Dotted name of the module.
        path : iterable of str or None
            Folders of its package; nothing depends on it.
        target : module, optional
            Python's; nothing depends on it.
        """
        if name != "rps":
            return None
        folders = os.environ.get("PYTHONPATH", "").split(os.pathsep)
        return PathFinder.find_spec(name, [f for f in folders if f.startswith(_IMPORT_PATHS)])


def _run_next() -> None:
    """Run the ``sitecustomize`` that Python would have run."""
    path = [entry for entry in sys.path if os.path.abspath(entry) != _HERE]
    spec = PathFinder.find_spec("sitecustomize", path)
    if spec is not None and spec.loader is not None:
        module = sys.modules["sitecustomize"] = module_from_spec(spec)
        spec.loader.exec_module(module)


def _keep_to_the_run() -> None:
    sys.meta_path.insert(0, RpsFirst())
    words = getattr(sys, "orig_argv", [])  # older Pythons, which scripts may start, have none
    command = next((word for word in words if word.startswith("from multiprocessing.")), "")
    if not command:
        return
    arrival: dict[str, Any] = {"__file__": os.path.join(_IMPORT_PATHS, "arrival.py")}
    code = SourceFileLoader("arrival", arrival["__file__"]).get_code("arrival")
    exec(code, arrival)  # type: ignore[arg-type]
    if command.startswith("from multiprocessing.resource_tracker "):
        arrival["keep_apart"](os.getcwd())
    else:
        arrival["arrive_as_worker"]()


_keep_to_the_run()
_run_next()
