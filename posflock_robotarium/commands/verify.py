"""``posflock verify`` and ``posflock profile``: whether a script will run on the testbed."""

from pathlib import Path
from typing import Annotated

import typer


def verify(
    script: Annotated[Path, typer.Argument(help="The experiment's main file.", show_default=False)],
    trials: Annotated[
        int | None,
        typer.Option(
            "--trials",
            "-n",
            help="Runs with imperfections. Default: 20, with --effect 5 each.",
        ),
    ] = None,
    profile: Annotated[
        str, typer.Option(help="Imperfections: ideal, gritsbot_x, harsh, or a TOML file.")
    ] = "gritsbot_x",
    duration: Annotated[
        float | None,
        typer.Option("--duration", "-d", help="Seconds you will declare at submission, if known."),
    ] = None,
    generation: Annotated[
        int, typer.Option(help="Generation of the API on the testbed, 1 or 2.")
    ] = 2,
    seed: Annotated[int, typer.Option(help="First seed of the trials.")] = 0,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Folder for verify.html and verify.json.")
    ] = None,
    json_only: Annotated[
        bool, typer.Option("--json", help="Print verify.json, and nothing else.")
    ] = False,
    effect: Annotated[
        list[str] | None,
        typer.Option(
            "--effect", help="Instead: run under this imperfection alone; 'each' for each in turn."
        ),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Trials at a time. Default: one a processor.")
    ] = None,
    stall: Annotated[
        float, typer.Option(help="Seconds without a step after which a trial hangs.")
    ] = 20.0,
    timeout: Annotated[float, typer.Option(help="Seconds that a trial may take.")] = 300.0,
    memory: Annotated[float, typer.Option(help="GiB that a trial may allocate.")] = 2.0,
) -> None:
    """Predict whether the testbed takes a script, runs it to its end, and returns its data.

    Exit code 0 is PASS, 1 is RISK, 2 is FAIL. 2 is also an error before there was a verdict, such
    as no such script: then one line on standard error and nothing on standard output.

    [bold]Examples[/bold]

        posflock verify experiments/robotarium_9bot.py

        posflock verify main.py --duration 300 -o results/verify

        posflock verify main.py --effect each
    """
    from rich.console import Console
    from rich.progress import Progress

    from posflock_robotarium.flocking.errors import ParameterError
    from posflock_robotarium.verify import EFFECT_TRIALS, TRIALS, ablate
    from posflock_robotarium.verify import verify as run
    from posflock_robotarium.verify.pages import write_report
    from posflock_robotarium.verify.terminal import print_ablation, print_report
    from posflock_robotarium.verify.trials import Limits

    for name, value in (("stall", stall), ("timeout", timeout), ("memory", memory)):
        if not value > 0:
            raise ParameterError(f"{name}: expected more than 0, got {value}")
    limits = Limits(
        jobs=Limits.jobs if jobs is None else jobs,
        stall=stall,
        seconds=timeout,
        memory=int(memory * 2**30),
    )
    console = Console(soft_wrap=not Console().is_terminal)
    with Progress(
        console=Console(stderr=True), transient=True, disable=json_only or not console.is_terminal
    ) as progress:
        task = progress.add_task("starting", total=None)

        def tell(what: str, done: int, total: int) -> None:
            progress.update(task, description=what, completed=done, total=total)

        if effect:
            named = [] if "each" in effect else effect
            rows = ablate(
                script,
                effects=named,
                trials=EFFECT_TRIALS if trials is None else trials,
                profile=profile,
                generation=generation,
                seed=seed,
                limits=limits,
                tell=tell,
            )
        else:
            report = run(
                script,
                trials=TRIALS if trials is None else trials,
                profile=profile,
                generation=generation,
                declared=duration,
                seed=seed,
                limits=limits,
                tell=tell,
            )
    if effect:
        if json_only:
            import json
            from dataclasses import asdict

            typer.echo(json.dumps([asdict(row) for row in rows], indent=1))
        else:
            print_ablation(rows, console)
        return
    written = write_report(report, out) if out is not None else []
    if json_only:
        import json

        typer.echo(json.dumps(report.as_dict(), indent=1))
    else:
        print_report(report, console)
        for path in written:
            console.print(f"wrote {path}", highlight=False)
    raise typer.Exit(report.exit_code)


def profile(
    name: Annotated[str, typer.Argument(help="ideal, gritsbot_x or harsh.")] = "gritsbot_x",
) -> None:
    """Print a realism profile as TOML, to copy and edit.

    Exit code 0, or 2 when there is no such profile.

    [bold]Examples[/bold]

        posflock profile gritsbot_x > lab.toml
    """
    from rps_compat.profiles import load_profile, profile_text

    load_profile(name)
    typer.echo(profile_text(name), nl=False)
