"""``posflock bundle`` and ``posflock rehearse``: what to upload, and a run of it."""

from pathlib import Path
from typing import Annotated

import typer

from rps_compat.testbed import MAX_DURATION


def bundle(
    script: Annotated[Path, typer.Argument(help="The experiment's main file.", show_default=False)],
    out: Annotated[
        Path,
        typer.Option(
            "--out", "-o", help="Folder to write: new, empty or a bundle.", show_default=False
        ),
    ],
    data: Annotated[
        list[Path] | None, typer.Option(help="A data file to take along; may be repeated.")
    ] = None,
    run: Annotated[
        bool,
        typer.Option(help="Run the script once to learn what to enter for robots and duration."),
    ] = True,
    max_size: Annotated[
        float | None, typer.Option(help="Largest upload in MiB. Default: no limit.")
    ] = None,
    json_only: Annotated[
        bool, typer.Option("--json", help="Print what was written as JSON.")
    ] = False,
) -> None:
    """Lay a script and all it imports flat, ready to be uploaded.

    What will stop it on the testbed all the same, such as names of generation 1 of the API, is a
    warning. Exit code 0, or 2 with the reason and the way out where it cannot be laid flat.

    [bold]Examples[/bold]

        posflock bundle experiments/robotarium_9bot.py -o upload

        posflock bundle main.py -o upload --data goals.npy --no-run
    """
    from posflock_robotarium.submission.bundle import bundle as lay_flat
    from posflock_robotarium.verify.findings import count
    from posflock_robotarium.verify.trials import robots_and_seconds

    robots, seconds = robots_and_seconds(script) if run else (None, None)
    ready = lay_flat(
        script,
        out,
        data=data or [],
        robots=robots,
        run_seconds=seconds,
        largest=None if max_size is None else int(max_size * 2**20),
    )
    if json_only:
        import json

        said = {
            "folder": str(ready.folder),
            "main": ready.main,
            "files": {name: len(content) for name, content in sorted(ready.files.items())},
            "left_out": ready.left_out,
            "robots": ready.robots,
            "duration": ready.duration,
            "warnings": list(ready.warnings),
        }
        typer.echo(json.dumps(said, indent=1))
        return
    size = max(1, round(ready.size / 1024))
    typer.echo(f"{count(len(ready.files), 'file')}, {size} KiB in {ready.folder}")
    if ready.left_out:
        names = (f"{name} ({library})" for name, library in sorted(ready.left_out.items()))
        typer.echo(f"left out, for libraries that the testbed has not: {', '.join(names)}")
    for warning in ready.warnings:
        typer.echo(f"warning: {warning}", err=True)
    typer.echo(f"main file {ready.main}; what to enter is in {ready.folder / 'SUBMIT.md'}")


def rehearse(
    folder: Annotated[
        Path, typer.Argument(help="A bundle, made by `posflock bundle`.", show_default=False)
    ],
    out: Annotated[
        Path, typer.Option("--out", "-o", help="New or empty folder for what comes back.")
    ] = Path("rehearsal"),
    duration: Annotated[
        float, typer.Option("--duration", "-d", help="Declared duration, seconds.")
    ] = MAX_DURATION,
    profile: Annotated[
        str, typer.Option(help="Imperfections: ideal, gritsbot_x, harsh, or a TOML file.")
    ] = "gritsbot_x",
    seed: Annotated[int, typer.Option(help="Of everything random that is the testbed's.")] = 0,
    generation: Annotated[int, typer.Option(help="Generation of the API, 1 or 2.")] = 2,
    initial: Annotated[
        str, typer.Option(help="arrive (within 5 cm and 0.2 rad), exact, or drive.")
    ] = "arrive",
    timeout: Annotated[float, typer.Option(help="Seconds of real time it may take.")] = 600.0,
    report: Annotated[
        bool, typer.Option(help="Open returned pose logs with posflock report.")
    ] = True,
    json_only: Annotated[bool, typer.Option("--json", help="Print the outcome as JSON.")] = False,
) -> None:
    """Run a bundle with the testbed's Python, libraries and folder, and without a network.

    The environment is built once and cached. Exit code 0 when the run ended by itself or by the
    declared duration, without a collision, and its files can be opened; 1 when not.

    [bold]Examples[/bold]

        posflock rehearse upload -o back --duration 320
    """
    from posflock_robotarium.submission.rehearse import rehearse as run
    from posflock_robotarium.verify.findings import count
    from rps_compat.report import NO_VIOLATIONS

    done = run(
        folder,
        out,
        duration=duration,
        profile=profile,
        seed=seed,
        generation=generation,
        initial=initial,
        timeout=timeout,
        tell=None if json_only else typer.echo,
    )
    page = None
    if report:
        from posflock_robotarium.submission.rehearse import report_on

        page = report_on(done)
    if json_only:
        import json

        said = done.as_dict() | {"report": None if page is None else str(page)}
        typer.echo(json.dumps(said, indent=1))
    else:
        environment = done.environment
        versions = ", ".join(f"{name} {v}" for name, v in environment.libraries.items())
        why = f": {done.reason}" if done.reason else ""
        outcome = done.outcome
        after = f" after {outcome.time:.1f} s" if outcome.time is not None else ""
        steps = f", {count(outcome.steps, 'step')}" if outcome.steps is not None else ""
        typer.echo(f"{outcome.ended}{after}{steps}{why}")
        typer.echo(f"environment: Python {environment.version}, {versions}; {done.network}")
        if environment.note:
            typer.echo(f"note: {environment.note}")
        for name, found in done.files.items():
            typer.echo(f"  {name}: {found}")
        if outcome.report is not None and outcome.report.verdict != NO_VIOLATIONS:
            typer.echo(f"  {outcome.report.verdict}")
        if page is not None:
            typer.echo(f"report: {page}")
        typer.echo(f"what came back is in {done.folder}, with log.txt")
    raise typer.Exit(0 if done.passed else 1)
