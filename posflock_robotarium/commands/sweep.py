"""``posflock sweep``: many runs of one experiment, described in a file."""

from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from posflock_robotarium.commands import options
from posflock_robotarium.commands.terminal import say

if TYPE_CHECKING:
    from posflock_robotarium.sweep.cluster import Certificates
    from posflock_robotarium.sweep.execution import Executor
    from posflock_robotarium.sweep.store import Row


def sweep(
    study: options.StudyFile,
    out: options.StudyFolder = None,
    jobs: options.Processes = None,
    retry_failed: options.RetryFailed = False,
    scheduler: options.Scheduler = None,
    tls_ca: options.ClusterAuthority = None,
    tls_cert: options.ClientCertificate = None,
    tls_key: options.ClientKey = None,
    as_json: options.DoneAsJson = False,
) -> None:
    """Run a study: grids and distributions of parameters, kept in a store that survives.

    Of point agents, of the nine robots, or of any Robotarium script, whose constants it varies.

    Started again, a sweep computes only what is missing, whatever ended it; all of it, where
    the code behind the experiment has changed.

    Writes results.csv, summary.csv and figures/ of what is finished, whatever ends it, with
    pyarrow (extra "parquet") results.parquet, and study.json, which says what they are of: those
    of another study in the folder go first. The finished runs are in store/. Exit code 0; 1 where
    runs failed, whose errors are in the tables; 2 where the study, its store or its cluster cannot
    be used.

    [bold]Examples[/bold]

        posflock sweep experiments/studies/noise.toml

        posflock sweep experiments/studies/noise.toml --scheduler tcp://10.0.0.1:8786
    """
    from posflock_robotarium.flocking.progress import counted
    from posflock_robotarium.sweep.cluster import Certificates
    from posflock_robotarium.sweep.execution import execute
    from posflock_robotarium.sweep.listing import forget_other_study, list_files
    from posflock_robotarium.sweep.results import (
        PARQUET,
        engines,
        finished,
        of_other_code,
        parquet_is_installed,
        write_tables,
    )
    from posflock_robotarium.sweep.store import Store
    from posflock_robotarium.sweep.study import read_study
    from posflock_robotarium.sweep.study_figures import draw_study

    asked = read_study(study)
    folder = out or Path("results") / study.stem
    executors = _executors(jobs, scheduler, Certificates.of(tls_ca, tls_cert, tls_key))
    with Store(folder / "store") as store:
        forget_other_study(asked, folder)
        there, stale = len(finished(asked, store)), of_other_code(asked, store)
        if stale:
            say(
                f"{_counted(stale, 'run')} in {folder / 'store'} left out: computed before"
                " a source was changed, kept for when it is changed back",
                err=True,
            )
        try:
            with executors as executor, counted(f"sweeping {study.stem}") as progress:
                computed = execute(asked, store, executor, progress, retry_failed)
        finally:  # whatever ended it
            rows = finished(asked, store)
            paths = write_tables(asked, store, folder)
            paths += draw_study(asked, rows, folder / "figures")
            paths.append(list_files(asked, folder, paths))
    done = {"computed": computed, "found": there, "other_code": stale, "torn": store.torn}
    if not parquet_is_installed():
        say(f"no {PARQUET}: it needs pip install 'posflock-robotarium[parquet]'", err=True)
    by = engines(asked, rows)
    if len(by) > 1:
        told = " and ".join(f"{number} by {name}" for name, number in sorted(by.items()))
        say(
            f"{told}: their last bits differ, as column engine of results.csv tells; for one engine"
            " give another folder with -o",
            err=True,
        )
    failed = _print(done, rows, folder, paths, as_json)
    raise typer.Exit(1 if failed else 0)


def _executors(
    jobs: int | None, scheduler: str | None, certificates: "Certificates | None"
) -> "AbstractContextManager[Executor]":
    """Return what computes the runs: a cluster, or processes of this machine."""
    from contextlib import nullcontext

    from posflock_robotarium.sweep.cluster import ClusterError, on_cluster
    from posflock_robotarium.sweep.execution import in_processes

    if scheduler is not None:
        return on_cluster(scheduler, certificates=certificates)
    if certificates is not None:
        raise ClusterError("certificates are for a cluster: name its --scheduler tls://…")
    return nullcontext(in_processes(jobs))


def _print(
    done: dict[str, int], rows: "list[Row]", folder: Path, paths: list[Path], as_json: bool
) -> int:
    """Print what was done; return how many runs failed."""
    import json

    from posflock_robotarium.sweep.store import ERROR

    errors = [row[ERROR] for row in rows if ERROR in row]
    if as_json:
        told = {**done, "failed": len(errors), "files": list(map(str, paths))}
        say(json.dumps(told, indent=2))
        return len(errors)
    say(f"{_counted(done['computed'], 'run')} computed, {done['found']} found; written: {folder}")
    if done["torn"]:
        lines = _counted(done["torn"], "torn line")
        say(f"{lines} in {folder / 'store'} left out and computed again")
    if errors:
        say(
            f"{_counted(len(errors), 'run')} failed, see {ERROR} in results.csv; the first:"
            f" {errors[0]}; --retry-failed computes them once more",
            err=True,
        )
    return len(errors)


def _counted(number: int, noun: str) -> str:
    return f"1 {noun}" if number == 1 else f"{number} {noun}s"
