"""Compute what a study lacks, by processes of this machine; `cluster` has others do it.

All do the same with the same function, :func:`compute`, whose result depends on nothing
but its arguments.  Where a run is computed, in which order and in whose company therefore
changes no number, and a worker that dies costs time only: its runs are computed again, one
by one.  A run that fails, or kills every worker that it is given to, becomes a row that
says why, and the rest goes on.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator, Hashable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path
from typing import Any

from posflock_robotarium import __version__
from posflock_robotarium.flocking.errors import PosflockError
from posflock_robotarium.simulation.workers import local_pool, processors
from posflock_robotarium.sweep.experiments import Experiment, Outcome
from posflock_robotarium.sweep.scripts import experiment_of
from posflock_robotarium.sweep.sources import code_of
from posflock_robotarium.sweep.store import ENGINE, ERROR, Row, Store
from posflock_robotarium.sweep.study import PlannedRun, Study

#: Letters of an error that a row keeps.
_LONGEST_ERROR = 500
#: Runs of different parameters that go together at least, though workers be idle.
_FEWEST_TOGETHER = 8
#: What is said of a run whose worker died.
DIED = "WorkerDied: its worker process died, of a crash, a kill or for want of memory"


class WorkerError(PosflockError):
    """A worker has other code than this process."""


@dataclass(frozen=True)
class Job:
    """What computes the batches of a study, in whatever process.

    Attributes
    ----------
    experiment : str
        Name of a registered experiment.
    module : Path or None
        The file that registers it, where it is a user's own.
    code : str
        Digest of the code that this process has.
    """

    experiment: str
    module: Path | None
    code: str

    def __call__(self, runs: Sequence[PlannedRun]) -> list[Row]:
        """Compute one batch, see :func:`compute`.

        Parameters
        ----------
        runs : sequence of PlannedRun
            Of one batch.
        """
        return compute(self.experiment, runs, self.module)

    def failed(self, runs: Sequence[PlannedRun], error: str) -> list[Row]:
        """Return the rows of runs that cannot be computed.

        Parameters
        ----------
        runs : sequence of PlannedRun
            Which ones.
        error : str
            Why.
        """
        return [_row(self.experiment, run, {ERROR: error}, 0.0, self.code) for run in runs]


#: What has a job compute all batches, in any order.
Executor = Callable[[Job, Sequence[Sequence[PlannedRun]]], Iterator[list[Row]]]


def execute(
    study: Study,
    store: Store,
    executor: Executor,
    progress: Callable[[int, int], None] = lambda done, all_: None,
    retry_failed: bool = False,
) -> int:
    """Compute every run of a study that the store lacks, and store it.

    Parameters
    ----------
    study : Study
        What is wanted.
    store : Store
        What is there, and where new rows go as soon as they are finished.
    executor : Executor
        :func:`locally`, :func:`in_processes`, or :func:`cluster.on_cluster`.
    progress : function of (done, all)
        Called whenever runs are finished, with the runs of this sweep alone.
    retry_failed : bool
        Whether runs that failed are computed again.

    Returns
    -------
    int
        How many runs were computed.

    Raises
    ------
    WorkerError
        Where a worker has other code than this process; nothing it computed is stored.
    """
    missing = [run for run in study.runs() if _is_missing(store.rows.get(run.key), retry_failed)]
    job = Job(study.experiment.name, study.module, study.code)
    done = 0
    for rows in executor(job, batches(missing, study.experiment, processors())):
        _require_same_code(rows, study.code)
        store.append(rows)
        done += len(rows)
        progress(done, len(missing))
    return done


def _is_missing(row: Row | None, retry_failed: bool) -> bool:
    return row is None or (retry_failed and ERROR in row)


def batches(
    runs: Iterable[PlannedRun], experiment: Experiment, workers: int = 1
) -> list[list[PlannedRun]]:
    """Group runs that can be computed in one call, in their order.

    Parameters
    ----------
    runs : iterable of PlannedRun
        What is asked for; each is in one batch.
    experiment : Experiment
        What they are runs of: it says which and how many go together.
    workers : int
        How many there are to do it: fewer runs than could go together do, rather than that one of
        them has all and others have none.
    """
    groups: dict[Hashable, list[PlannedRun]] = {}
    for run in runs:
        groups.setdefault(experiment.company(run.parameters), []).append(run)
    made = []
    for alike in groups.values():
        most = experiment.together
        if experiment.run_mixed is not None:
            most = min(most, max(_FEWEST_TOGETHER, math.ceil(len(alike) / workers)))
        made += [alike[at : at + most] for at in range(0, len(alike), most)]
    return made


def compute(experiment: str, runs: Sequence[PlannedRun], module: Path | None = None) -> list[Row]:
    """Compute one batch of runs.

    Parameters
    ----------
    experiment : str
        Name of a registered experiment.
    runs : sequence of PlannedRun
        Such as can be computed in one call.
    module : Path, optional
        The file that registers the experiment, where it is a user's own.

    Returns
    -------
    list of rows
        Everything that decides a run, then what came out or the error that it ended with,
        ``seconds`` of CPU time a run, the ``version`` and the digest of the ``code`` that computed
        it, and the ``engine`` where there are several.
    """
    found = experiment_of(experiment, module)
    code = code_of(found, module)
    started = time.process_time()
    try:
        parameters, seeds = [run.parameters for run in runs], [run.stream for run in runs]
        outcomes = _checked(found.outcomes(parameters, seeds), len(runs))
    except (Exception, SystemExit) as error:
        if len(runs) > 1:  # one of them, perhaps: the others are not to end by it
            halves = runs[: len(runs) // 2], runs[len(runs) // 2 :]
            return [row for half in halves for row in compute(experiment, half, module)]
        outcomes = [{ERROR: words_of(error)}]
    seconds = (time.process_time() - started) / len(runs)
    rows = [
        _row(experiment, run, outcome, seconds, code)
        for run, outcome in zip(runs, outcomes, strict=True)
    ]
    for row, run in zip(rows, runs, strict=True):
        if found.engine is not None and ERROR not in row:
            row[ENGINE] = found.engine(run.parameters)
    return rows


def words_of(error: BaseException) -> str:
    """Return an error as one line.

    Parameters
    ----------
    error : BaseException
        What was raised.
    """
    words = " ".join(str(error).split()) or "no reason given"
    return f"{type(error).__name__}: {words}"[:_LONGEST_ERROR]


def _checked(outcomes: Sequence[Outcome], expected: int) -> list[dict[str, Any]]:
    """Return what came out of the runs, or refuse what a row cannot hold."""
    if len(outcomes) != expected:
        raise ValueError(f"expected {expected} outcomes, one a seed, got {len(outcomes)}")
    found: list[dict[str, Any]] = []
    for outcome in outcomes:
        if not isinstance(outcome, Mapping) or ERROR in outcome:
            raise TypeError(f"expected a dict of numbers without {ERROR!r}, got {outcome!r}")
        numbers = {
            str(name): value if isinstance(value, (int, float)) else float(value)
            for name, value in outcome.items()
        }
        found.append(numbers)
    return found


def _row(
    experiment: str, run: PlannedRun, outcome: Mapping[str, Any], seconds: float, code: str
) -> Row:
    """Return everything that decides a run, and what came out."""
    return {
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


def locally(workers: int | None = None) -> Executor:
    """Return an executor of so many processes; by default one for each processor.

    Parameters
    ----------
    workers : int, optional
        One computes in this process, and so does whoever has one batch to compute: what
        kills a run then kills all.
    """
    count = workers or processors()

    def run(job: Job, work: Sequence[Sequence[PlannedRun]]) -> Iterator[list[Row]]:
        if count == 1 or len(work) < 2:
            yield from (job(batch) for batch in work)
        else:
            yield from in_processes(count)(job, work)

    return run


def in_processes(workers: int | None = None) -> Executor:
    """Return an executor of so many processes, none of them this one.

    Where a process dies, so does the pool it is of. The runs that may have killed it are then
    computed one after the other in a pool of one, which finds the one that does.

    Parameters
    ----------
    workers : int, optional
        By default one for each processor.
    """
    count = workers or processors()

    def run(job: Job, work: Sequence[Sequence[PlannedRun]]) -> Iterator[list[Row]]:
        todo = iter(work)
        while left := (yield from _until_a_worker_dies(job, todo, min(count, len(work) or 1))):
            # In the order of their submission: those in work, and the one that is next.
            yield from _one_by_one(job, left[: count + 1])
            todo = chain(left[count + 1 :], todo)

    return run


def _until_a_worker_dies(
    job: Job, todo: Iterator[Sequence[PlannedRun]], count: int
) -> Generator[list[Row], None, list[Sequence[PlannedRun]]]:
    """Yield the rows of finished batches; return those that were begun when a worker died."""
    with local_pool(count) as pool:
        # A few batches ahead of each worker: none waits, and a long study needs no memory.
        pending: dict[Future[list[Row]], Sequence[PlannedRun]] = {}
        while True:
            for batch in islice(todo, 3 * count - len(pending)):
                try:
                    pending[pool.submit(job, batch)] = batch
                except BrokenProcessPool:
                    return [*pending.values(), batch]
            if not pending:
                return []
            for future in wait(pending, return_when=FIRST_COMPLETED).done:
                if isinstance(future.exception(), BrokenProcessPool):
                    return list(pending.values())
                del pending[future]
                yield future.result()


def _one_by_one(job: Job, batches: Iterable[Sequence[PlannedRun]]) -> Iterator[list[Row]]:
    """Yield the rows of batches, each computed alone; a run that kills its worker has failed."""
    todo = list(batches)
    while todo:
        with local_pool(1) as pool:
            while todo:
                batch = todo.pop(0)
                try:
                    rows = pool.submit(job, batch).result()
                except BrokenProcessPool:
                    break
                yield rows
            else:
                return
        if len(batch) > 1:
            todo = [[run] for run in batch] + todo
        else:
            yield job.failed(batch, DIED)


def _require_same_code(rows: Sequence[Row], code: str) -> None:
    if any(row["code"] != code for row in rows):
        raise WorkerError(
            "a worker computed with other code than this process has: a source was changed during"
            " the sweep, or the workers of a cluster were started before it was. Finished runs are"
            " in the store: restart the workers and start again"
        )
