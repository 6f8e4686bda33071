"""``posflock sweep``: many runs of one experiment, described in a file."""

from pathlib import Path
from typing import Annotated

import typer


def sweep(
    study: Annotated[Path, typer.Argument(help="A study file, TOML.")],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="Folder; by default results/ and the study's name."),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes; by default one a processor.")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Send the runs to this Dask scheduler.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what was done as JSON.")] = False,
) -> None:
    """Run a study: grids and distributions of parameters, kept in a store that survives.

    Started again, a sweep computes only what is missing, whatever ended it.

    For example, here, and on a cluster:

    [bold]posflock sweep experiments/studies/noise.toml[/bold]

    [bold]posflock sweep experiments/studies/noise.toml --scheduler tcp://10.0.0.1:8786[/bold]

    Writes results.csv, results.parquet, summary.csv and figures/; the finished runs are in
    store/.
    """
    import json
    from contextlib import nullcontext

    from posflock_robotarium.progress import counted
    from posflock_robotarium.sweep.execution import execute, locally, on_cluster
    from posflock_robotarium.sweep.figures import draw_study
    from posflock_robotarium.sweep.results import finished, write_tables
    from posflock_robotarium.sweep.store import Store
    from posflock_robotarium.sweep.study import read_study

    asked = read_study(study)
    folder = out or Path("results") / study.stem
    executors = on_cluster(scheduler) if scheduler else nullcontext(locally(workers))
    with Store(folder / "store") as store, executors as executor:
        there = len(finished(asked, store))
        with counted(f"sweeping {study.stem}") as progress:
            computed = execute(asked, store, executor, progress)
        paths = write_tables(asked, store, folder)
        paths += draw_study(asked, finished(asked, store), folder / "figures")
        torn = store.torn
    if as_json:
        done = {"computed": computed, "found": there, "torn": torn, "files": list(map(str, paths))}
        typer.echo(json.dumps(done, indent=2))
        return
    typer.echo(f"{computed} runs computed, {there} were there; written: {folder}")
    if torn:
        typer.echo(f"{torn} torn lines in {folder / 'store'} were left out, their runs repeated")
