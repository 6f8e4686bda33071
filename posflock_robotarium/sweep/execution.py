"""Compute what a study lacks: by processes of this machine, or on a Dask cluster.

Both do the same with the same function, :func:`compute`, whose result depends on nothing
but its arguments.  Where a run is computed, in which order and in whose company therefore
changes no number, and a worker that dies costs time only: its runs are computed again.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from itertools import groupby, islice
from pathlib import Path

from posflock_robotarium import __version__
from posflock_robotarium.flocking.errors import PosflockError
from posflock_robotarium.simulation.workers import local_pool, processors
from posflock_robotarium.sweep.experiments import find
from posflock_robotarium.sweep.sources import code_of, load
from posflock_robotarium.sweep.store import Row, Store
from posflock_robotarium.sweep.study import Run, Study

#: What computes one batch, and what has it compute all batches, in any order.
Job = Callable[[Sequence[Run]], list[Row]]
Executor = Callable[[Job, Sequence[Sequence[Run]]], Iterator[list[Row]]]


class WorkerError(PosflockError):
    """A worker process died, or has other code than this one."""


class ClusterError(PosflockError):
    """A Dask cluster cannot be used."""


def execute(
    study: Study,
    store: Store,
    executor: Executor,
    progress: Callable[[int, int], None] = lambda done, all_: None,
) -> int:
    """Compute every run of a study that the store lacks, and store it.

    Parameters
    ----------
    study : Study
        What is wanted.
    store : Store
        What is there, and where new rows go as soon as they are finished.
    executor : Executor
        :func:`locally`, or :func:`on_cluster`.
    progress : function of (done, all)
        Called whenever runs are finished, with the runs of this sweep alone.

    Returns
    -------
    int
        How many runs were computed.

    Raises
    ------
    WorkerError
        Where a worker has other code than this process; nothing it computed is stored.
    """
    missing = [run for run in study.runs() if run.key not in store.rows]
    job = partial(compute, study.experiment.name, module=study.module)
    done = 0
    for rows in executor(job, batches(missing, study.experiment.together)):
        _require_same_code(rows, study.code)
        store.append(rows)
        done += len(rows)
        progress(done, len(missing))
    return done


def batches(runs: Iterable[Run], together: int) -> list[list[Run]]:
    """Group runs with equal parameters into batches of at most so many.

    Parameters
    ----------
    runs : iterable of Run
        The runs, those with equal parameters side by side.
    together : int
        Most runs in a batch.
    """
    made = []
    for _, group in groupby(runs, key=lambda run: sorted(run.parameters.items())):
        alike = list(group)
        made += [alike[at : at + together] for at in range(0, len(alike), together)]
    return made


def compute(experiment: str, runs: Sequence[Run], module: Path | None = None) -> list[Row]:
    """Compute one batch of runs with equal parameters.

    Parameters
    ----------
    experiment : str
        Name of a registered experiment.
    runs : sequence of Run
        With one set of parameters.
    module : Path, optional
        The file that registers the experiment, where it is a user's own.

    Returns
    -------
    list of rows
        Everything that decides a run, then what came out, ``seconds`` of CPU time a run, and
        the ``version`` and the digest of the ``code`` that computed it.
    """
    if module:
        load(module)
    found = find(experiment)
    code = code_of(found, module)
    started = time.process_time()
    outcomes = found.run(runs[0].parameters, [run.stream for run in runs])
    seconds = (time.process_time() - started) / len(runs)
    return [
        {
            "key": run.key,
            "point": run.point,
            "replication": run.replication,
            "experiment": experiment,
            "study_seed": run.stream.entropy,
            **run.parameters,
            **outcome,
            "seconds": round(seconds, 6),
            "version": __version__,
            "code": code,
        }
        for run, outcome in zip(runs, outcomes, strict=True)
    ]


def locally(workers: int | None = None) -> Executor:
    """Return an executor of so many processes; by default one for each processor.

    Parameters
    ----------
    workers : int, optional
        One computes in this process.
    """
    count = workers or processors()

    def run(job: Job, work: Sequence[Sequence[Run]]) -> Iterator[list[Row]]:
        if count == 1 or len(work) < 2:
            yield from (job(batch) for batch in work)
            return
        todo = iter(work)
        with local_pool(min(count, len(work))) as pool:
            # A few batches ahead of each worker: none waits, and a long study needs no memory.
            pending: set[Future[list[Row]]] = set()
            while True:
                for batch in islice(todo, 3 * count - len(pending)):
                    pending.add(pool.submit(job, batch))
                if not pending:
                    return
                finished, pending = wait(pending, return_when=FIRST_COMPLETED)
                try:
                    yield from (future.result() for future in finished)
                except BrokenProcessPool as error:
                    raise WorkerError(
                        "a worker process died, perhaps for want of memory; finished runs are in"
                        " the store: start again, with fewer --workers"
                    ) from error

    return run


@contextmanager
def on_cluster(address: str, patience: float = 10.0) -> Iterator[Executor]:
    """Connect to a Dask scheduler and give an executor that sends it the work.

    Dask's workers pin BLAS to one thread by themselves, and its scheduler gives the runs of
    a worker that died to another.

    Parameters
    ----------
    address : str
        Of the scheduler, such as ``tcp://10.0.0.1:8786``.
    patience : float
        Seconds to wait for the scheduler.

    Raises
    ------
    ClusterError
        Where Dask is not installed, nobody answers, or a worker has another version.
    """
    try:
        from distributed import Client, as_completed
    except ImportError as error:
        raise ClusterError(
            "a cluster needs Dask: pip install 'posflock-robotarium[cluster]'"
        ) from error
    try:
        client = Client(address, timeout=patience, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise ClusterError(f"no Dask scheduler answers at {address}: {error}") from error

    def run(job: Job, work: Sequence[Sequence[Run]]) -> Iterator[list[Row]]:
        futures = client.map(job, work, pure=False, retries=2, batch_size=100)
        for future in as_completed(futures, loop=client.loop):
            rows: list[Row] = future.result()
            yield rows
            future.release()

    try:
        _require_same_version(client.run(_version))
        yield run
    finally:
        client.close()


def _require_same_code(rows: Sequence[Row], code: str) -> None:
    if any(row["code"] != code for row in rows):
        raise WorkerError(
            "a worker computed with other code than this process has: a source was changed during"
            " the sweep, or the workers of a cluster were started before it was. Finished runs are"
            " in the store: restart the workers and start again"
        )


def _version() -> str:
    return __version__


def _require_same_version(versions: dict[str, str]) -> None:
    others = {worker: found for worker, found in versions.items() if found != __version__}
    if others:
        worker, found = next(iter(others.items()))
        raise ClusterError(
            f"posflock-robotarium {__version__} is expected on every worker; {worker} has {found}"
        )
