"""Processes that a script leaves when it ends, treated as Python treats them when it exits.

Under plain Python, the end of a script is the end of its process: pools that are still open are
closed, daemons are ended, all other processes are waited for. Here the process goes on, to report,
so the same is done for what the script has started, and nothing else.
"""

import math
import traceback
from typing import Any

from rps_compat.own_imports.whose import environments_module

#: How `multiprocessing` starts processes; what other libraries start they look after themselves.
_METHODS = (None, "fork", "spawn", "forkserver")
#: Seconds that a process has to close what it keeps when it is ended.
GRACE = 3.0


class Leftovers:
    """What the script of this process has started since this was made."""

    def __init__(self) -> None:
        self._finalizers = set(_finalizers())
        self._processes = set(_processes())
        self._server = _server()

    def wait_for(self) -> None:
        """Close pools of `multiprocessing`, end daemons, wait for other processes."""
        self._finalize(0)
        processes = set(_processes()) - self._processes
        for process in processes:
            if process.daemon:
                process.terminate()
        for process in processes:
            process.join()
        self._stop_server()
        self._finalize(-math.inf)

    def _finalize(self, least: float) -> None:
        """Run what `multiprocessing` is to do at the exit, where its priority is at `least` so."""
        registry = _finalizers()
        keys = (key for key in registry if key not in self._finalizers and key[0] is not None)
        for key in sorted((key for key in keys if key[0] >= least), reverse=True):
            try:
                registry[key]()
            except Exception:
                traceback.print_exc()

    def end(self) -> None:
        """End all processes, at once."""
        processes = set(_processes()) - self._processes
        for process in processes:
            process.terminate()
        for process in processes:
            process.join(GRACE)
        self._stop_server()

    def _stop_server(self) -> None:
        """Stop the server from which `multiprocessing` forks: it has the environment of the run."""
        server = _server()
        if server is not None and server is not self._server:
            server._stop()


def _processes() -> list[Any]:
    module = environments_module("multiprocessing")
    if module is None:
        return []
    return [p for p in module.active_children() if getattr(p, "_start_method", "") in _METHODS]


def _finalizers() -> dict[Any, Any]:
    found = getattr(environments_module("multiprocessing.util"), "_finalizer_registry", {})
    return dict(found)


def _server() -> Any:
    """Return the server from which `multiprocessing` forks processes, if it runs."""
    server = getattr(environments_module("multiprocessing.forkserver"), "_forkserver", None)
    return server if getattr(server, "_forkserver_pid", None) is not None else None
