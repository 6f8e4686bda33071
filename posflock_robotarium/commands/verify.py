"""``posflock verify`` and ``posflock profile``: whether a script will run on the testbed."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from posflock_robotarium.commands import options
from posflock_robotarium.commands.terminal import say

if TYPE_CHECKING:
    from rich.console import Console

    from posflock_robotarium.verify import Ablation, Report
    from posflock_robotarium.verify.trials import Limits


def verify(
    script: options.Script,
    trials: options.Trials = None,
    profile: options.TestbedProfile = None,
    duration: options.Declared = None,
    generation: options.TestbedGeneration = 2,
    seed: options.FirstSeed = 0,
    out: options.VerifyFolder = None,
    json_only: options.VerifyAsJson = False,
    effect: options.Effects = None,
    jobs: options.Jobs = None,
    stall: options.Stall = 20.0,
    timeout: options.TrialSeconds = 300.0,
    memory: options.TrialMemory = 2.0,
    disk: options.TrialDisk = 0.5,
) -> None:
    """Predict whether the testbed takes a script, runs it to its end, and returns its data.

    Exit code 0 is PASS, 1 is RISK, 2 is FAIL. 2 is also an error before there was a verdict, such
    as no such script: then one line on standard error and nothing on standard output.

    [bold]Examples[/bold]

        posflock verify experiments/robotarium_9bot.py

        posflock verify main.py --duration 300 -o results/verify

        posflock verify main.py --effect each
    """
    from posflock_robotarium import verify as judging
    from posflock_robotarium.verify.pages import forget_report

    if out is not None and not effect:
        forget_report(out)
    limits = _limits(jobs, stall, timeout, memory, disk)
    console = _console()
    with _progress(hidden=json_only or not console.is_terminal) as tell:
        if effect:
            rows = judging.ablate(
                script,
                effects=[] if "each" in effect else effect,
                trials=judging.EFFECT_TRIALS if trials is None else trials,
                profile=profile,
                generation=generation,
                seed=seed,
                limits=limits,
                tell=tell,
            )
        else:
            report = judging.verify(
                script,
                trials=judging.TRIALS if trials is None else trials,
                profile=profile,
                generation=generation,
                declared=duration,
                seed=seed,
                limits=limits,
                tell=tell,
            )
    if effect:
        _print_ablation(rows, console, json_only)
        return
    _print_report(report, out, console, json_only)
    raise typer.Exit(report.exit_code)


def _limits(jobs: int | None, stall: float, timeout: float, memory: float, disk: float) -> "Limits":
    from posflock_robotarium.flocking.errors import ParameterError
    from posflock_robotarium.verify.trials import Limits

    asked = {"stall": stall, "timeout": timeout, "memory": memory, "disk": disk}
    for name, value in asked.items():
        if not value > 0:
            raise ParameterError(f"{name}: expected more than 0, got {value}")
    allowed = Limits(
        stall=stall, seconds=timeout, memory=int(memory * 2**30), disk=int(disk * 2**30)
    )
    return allowed if jobs is None else replace(allowed, jobs=jobs)


def _console() -> "Console":
    """Return where results are printed; lines for a program are not wrapped."""
    from rich.console import Console

    return Console(soft_wrap=not Console().is_terminal)


@contextmanager
def _progress(hidden: bool) -> Iterator[Callable[[str, int, int], None]]:
    """Yield what is told of the trials: which, how many are done, of how many."""
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True, disable=hidden) as progress:
        task = progress.add_task("starting", total=None)

        def tell(what: str, done: int, total: int) -> None:
            progress.update(task, description=what, completed=done, total=total)

        yield tell


def _print_ablation(rows: list["Ablation"], console: "Console", as_json: bool) -> None:
    if as_json:
        import json

        say(json.dumps([asdict(row) | {"interval": row.interval} for row in rows], indent=1))
        return
    from posflock_robotarium.verify.terminal import print_ablation

    print_ablation(rows, console)


def _print_report(report: "Report", out: Path | None, console: "Console", as_json: bool) -> None:
    """Write the report where a folder is named, and print it."""
    from posflock_robotarium.verify.pages import write_report
    from posflock_robotarium.verify.terminal import print_report

    written = write_report(report, out) if out is not None else []
    if as_json:
        import json

        say(json.dumps(report.as_dict(), indent=1))
        return
    print_report(report, console)
    for path in written:
        say(f"wrote {path}")


def profile(
    name: Annotated[
        str, typer.Argument(help="ideal, gritsbot_x, gternal or harsh.")
    ] = "gritsbot_x",
    json: options.ProfileAsJson = False,
) -> None:
    """Print a realism profile as TOML, to copy and edit.

    Exit code 0, or 2 when there is no such profile.

    [bold]Examples[/bold]

        posflock profile gritsbot_x > lab.toml
    """
    from rps_compat.profiles import load_profile, profile_text, profile_to_dict

    found = load_profile(name)
    if json:
        import json as writer

        say(writer.dumps(profile_to_dict(found), indent=1, ensure_ascii=False))
        return
    say(profile_text(name), end="")
