"""``posflock run`` and ``posflock lint``: any Robotarium script, as it is."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from posflock_robotarium.commands import options
from posflock_robotarium.commands.terminal import say

#: The exit code of programs that do not know an option, by argparse and by click.
USAGE = 2


def run(
    context: typer.Context,
    script: options.ScriptAndArguments,
    generation: options.FoundGeneration = None,
    headless: options.Headless = None,
    initial: options.Initial = "published",
    seed: options.ScriptSeed = None,
    profile: options.Profile = "ideal",
    timeout: options.StopAfter = None,
    answer: options.Answers = None,
    snapshot: options.Snapshots = "",
    video: options.RunFilm = None,
    out: options.RunFolder = None,
    as_json: options.ReportAsJson = False,
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
        out=out,
        snapshots=snapshot_times(snapshot),
        video=video,
        recorder=open_pose_log,
        tell=lambda note: say(f"{script}: {note}", err=True),
    )
    code = run_and_tell(script, context.args, settings, as_json)
    if code == USAGE and (option := _misplaced(context)):
        say(
            f"posflock: {option} stands after {script} and so went to the script; put posflock's"
            f" options before it: posflock run {option} … {script}",
            err=True,
        )
    raise typer.Exit(code)


def _misplaced(context: typer.Context) -> str | None:
    """Return the first of the script's arguments that is an option of this command."""
    own = {name for p in context.command.params for name in (*p.opts, *p.secondary_opts)}
    return next((word for word in context.args if word.partition("=")[0] in own), None)


def _print_script(content: bytes, encoding: str) -> None:
    """Print a script: its very bytes for a program that reads them, printable on a terminal."""
    if sys.stdout.isatty():
        say(content.decode(encoding).replace("\r\n", "\n"), end="")
    else:
        typer.echo(content, nl=False)


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

    from posflock_robotarium.flocking.errors import ParameterError
    from rps_compat.lint import lint_script, rewritten
    from rps_compat.whole_files import write_whole, written_together

    if generation == 1:
        raise ParameterError("--generation 1: scripts are rewritten for generation 2 only")
    source, findings = lint_script(script)
    needed = any(finding.needed for finding in findings)
    if as_json:
        say(json.dumps([asdict(finding) for finding in findings], indent=1))
    else:
        for finding in findings:
            left = "  [by hand]" if generation and finding.by_hand else ""
            name = script.with_name(finding.file) if finding.file else script
            say(f"{name}:{finding.line}: {finding.message}{left}", err=bool(generation))
        if not needed:
            clean = "nothing to change for generation 2, numpy 2.2 and Python 3.10"
            say(f"{script}: {clean}", err=bool(generation))
    if generation:
        new = rewritten(source, findings)
        if out is None:
            _print_script(new, source.encoding)
        else:
            with written_together(out.parent) as draft:
                write_whole(draft / out.name, new)
            changed = len({finding.line for finding in findings if finding.edits})
            left_over = len({(one.file, one.line) for one in findings if one.by_hand})
            lines = f"{changed} line{'' if changed == 1 else 's'}"
            say(f"wrote {out}: {lines} changed, {left_over} to change by hand", err=True)
    raise typer.Exit(1 if needed else 0)
