"""Spread independent computations over this machine's processors.

Each worker is a process of its own with one BLAS thread: small matrices only lose time to
more, and two workers with two threads each would fight over two processors.

A worker does not outlive its parent.  Waiting for work is reading a pipe, and a pipe ends
only when the last writer closes it; but every worker holds the pipes of its siblings, so
that the workers of a parent that was killed would wait on each other for ever.  Each
therefore watches its parent itself.
"""

from __future__ import annotations

import multiprocessing
import os
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import wait

#: What the common BLAS and OpenMP libraries read, once, when they are loaded.
THREAD_VARIABLES = (
    "OPENBLAS_NUM_THREADS",
    "OMP_NUM_THREADS",
    "MKL_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)


def processors() -> int:
    """Return how many processors this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on macOS
        return os.cpu_count() or 1


@contextmanager
def local_pool(workers: int | None = None) -> Iterator[ProcessPoolExecutor]:
    """Open a pool of single-threaded worker processes.

    Processes are started afresh rather than forked, so that they read the pinned thread
    counts before they load numpy; a script that calls this needs the usual
    ``if __name__ == "__main__":``.

    Parameters
    ----------
    workers : int, optional
        Processes; one for each processor by default.
    """
    before = {name: os.environ.get(name) for name in THREAD_VARIABLES}
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    pool = ProcessPoolExecutor(
        workers or processors(),
        multiprocessing.get_context("spawn"),
        initializer=_die_with_the_parent,
    )
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _die_with_the_parent() -> None:
    """End this worker process, in whatever it does, as soon as its parent is gone."""
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def watch() -> None:
        wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, name="watch the parent", daemon=True).start()
