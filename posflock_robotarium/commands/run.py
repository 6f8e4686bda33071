"""``posflock run`` and ``posflock lint``: any Robotarium script, as it is."""

from pathlib import Path
from typing import Annotated

import typer


def run(
    context: typer.Context,
    script: Annotated[Path, typer.Argument(help="The script; what follows it is its own.")],
    generation: Annotated[
        int | None,
        typer.Option(min=1, max=2, help="Of the API. Default: found in the source."),
    ] = None,
    headless: Annotated[
        bool | None,
        typer.Option(
            "--headless/--window", help="No window, no waiting. Default without a display."
        ),
    ] = None,
    initial: Annotated[
        str,
        typer.Option(
            help="How robots come to their initial conditions: published, exact, arrive (within "
            "the testbed's 5 cm and 0.2 rad) or drive."
        ),
    ] = "published",
    seed: Annotated[
        int | None,
        typer.Option(
            help="Seed of Python's and numpy's global generators: on one machine, the same bytes."
        ),
    ] = None,
    profile: Annotated[
        str, typer.Option(help="Imperfections: ideal, gritsbot_x, harsh, or a file profile.toml.")
    ] = "ideal",
    timeout: Annotated[
        float | None, typer.Option(help="Stop the script after so many seconds.")
    ] = None,
    answer: Annotated[
        list[str] | None, typer.Option("--input", help="An answer to input(); repeatable.")
    ] = None,
    snapshot: Annotated[str, typer.Option(help="Save the figure at these seconds: 0,10,end")] = "",
    video: Annotated[
        Path | None, typer.Option(help="Film the run, in the output folder: run.mp4 or .gif")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="Folder for log, report, pictures. Default runs/SCRIPT."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
) -> None:
    """Run a Robotarium script of either generation, unmodified, and keep its pose log.

    The exit code is the script's own: 0 when it finished, 1 after an exception, 124 after the
    timeout, 130 after Ctrl-C; 3 when all that was left waited for ever, 4 when it made a
    Robotarium and never stepped it.

    [bold]Examples[/bold]

        posflock run formation.py

        posflock run --seed 1 --timeout 60 --snapshot 0,end -o results formation.py --robots 7
    """
    from posflock_robotarium.logs.recorder import open_pose_log
    from rps_compat.process import run_and_tell
    from rps_compat.profiles import load_profile
    from rps_compat.run_settings import RunSettings, snapshot_times

    settings = RunSettings(
        generation=generation,  # type: ignore[arg-type]  # checked by the option
        headless=headless,
        initial=initial,  # type: ignore[arg-type]  # checked by the session
        seed=seed,
        profile=load_profile(profile),
        timeout=timeout,
        answers=answer or (),
        out=out or Path("runs") / script.stem,
        snapshots=snapshot_times(snapshot),
        video=video,
        recorder=open_pose_log,
        tell=lambda note: typer.echo(f"{script}: {note}", err=True),
    )
    code = run_and_tell(script, context.args, settings, as_json)
    raise typer.Exit(code)


def lint(
    script: Annotated[Path, typer.Argument(help="A script of generation 1 or 2.")],
    generation: Annotated[
        int | None, typer.Option(min=1, max=2, help="2 rewrites the script for generation 2.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="File for the rewritten script. Default: the terminal."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the findings as JSON.")] = False,
) -> None:
    """List what has to change before the testbed of today runs a script; --generation 2 changes it.

    Names of generation 1, defaults that changed, and what numpy 2.2 and Python 3.10 do not have.
    The exit code is 0 when nothing was found, 1 when something is to be changed.

    [bold]Examples[/bold]

        posflock lint old_script.py

        posflock lint old_script.py --generation 2 -o new_script.py
    """
    import json
    from dataclasses import asdict

    from posflock_robotarium.flocking.errors import OutputError, ParameterError
    from rps_compat.lint import lint_script, rewritten

    if generation == 1:
        raise ParameterError("--generation 1: scripts are rewritten for generation 2 only")
    source, findings = lint_script(script)
    needed = any(finding.needed for finding in findings)
    if as_json:
        typer.echo(json.dumps([asdict(finding) for finding in findings], indent=1))
    else:
        for finding in findings:
            left = "  [by hand]" if generation and finding.by_hand else ""
            name = script.with_name(finding.file) if finding.file else script
            typer.echo(f"{name}:{finding.line}: {finding.message}{left}", err=bool(generation))
        if not needed:
            clean = "nothing to change for generation 2, numpy 2.2 and Python 3.10"
            typer.echo(f"{script}: {clean}", err=bool(generation))
    if generation:
        new = rewritten(source, findings)
        if out is None:
            typer.echo(new, nl=False)
        else:
            try:
                out.parent.mkdir(parents=True, exist_ok=True)
                out.write_bytes(new)
            except OSError as error:
                raise OutputError(f"cannot write {out}: {error.strerror or error}") from error
    raise typer.Exit(1 if needed else 0)
