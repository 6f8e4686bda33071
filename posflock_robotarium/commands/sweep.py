"""``posflock sweep``: many runs of one experiment, described in a file."""

from pathlib import Path

from posflock_robotarium.commands import options
from posflock_robotarium.commands.terminal import say


def sweep(
    study: options.StudyFile,
    out: options.StudyFolder = None,
    workers: options.Workers = None,
    scheduler: options.Scheduler = None,
    as_json: options.DoneAsJson = False,
) -> None:
    """Run a study: grids and distributions of parameters, kept in a store that survives.

    Started again, a sweep computes only what is missing, whatever ended it; all of it, where
    the code behind the experiment has changed.

    Writes results.csv, results.parquet, summary.csv and figures/; the finished runs are in
    store/.

    [bold]Examples[/bold]

        posflock sweep experiments/studies/noise.toml

        posflock sweep experiments/studies/noise.toml --scheduler tcp://10.0.0.1:8786
    """
    import json
    from contextlib import nullcontext

    from posflock_robotarium.flocking.progress import counted
    from posflock_robotarium.sweep.execution import execute, locally, on_cluster
    from posflock_robotarium.sweep.results import finished, of_other_code, write_tables
    from posflock_robotarium.sweep.store import Store
    from posflock_robotarium.sweep.study import read_study
    from posflock_robotarium.sweep.study_figures import draw_study

    asked = read_study(study)
    folder = out or Path("results") / study.stem
    executors = on_cluster(scheduler) if scheduler else nullcontext(locally(workers))
    with Store(folder / "store") as store, executors as executor:
        there, stale = len(finished(asked, store)), of_other_code(asked, store)
        if stale:
            say(
                f"{_counted(stale, 'run')} in {folder / 'store'} left out: computed before"
                " a source was changed, kept for when it is changed back",
                err=True,
            )
        with counted(f"sweeping {study.stem}") as progress:
            computed = execute(asked, store, executor, progress)
        paths = write_tables(asked, store, folder)
        paths += draw_study(asked, finished(asked, store), folder / "figures")
        torn = store.torn
    if as_json:
        done = {"computed": computed, "found": there, "other_code": stale, "torn": torn}
        say(json.dumps(done | {"files": list(map(str, paths))}, indent=2))
        return
    say(f"{_counted(computed, 'run')} computed, {there} found; written: {folder}")
    if torn:
        lines = _counted(torn, "torn line")
        say(f"{lines} in {folder / 'store'} left out and computed again")


def _counted(number: int, noun: str) -> str:
    return f"1 {noun}" if number == 1 else f"{number} {noun}s"
