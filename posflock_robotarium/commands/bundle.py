"""``posflock bundle`` and ``posflock rehearse``: what to upload, and a run of it."""

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from posflock_robotarium.commands import options
from posflock_robotarium.commands.terminal import say
from rps_compat.testbed import MAX_DURATION

if TYPE_CHECKING:
    from posflock_robotarium.submission.rehearse import Rehearsal
    from posflock_robotarium.submission.upload_folder import Bundle


def bundle(
    script: options.Script,
    out: options.BundleFolder,
    data: options.DataFiles = None,
    run: options.RunOnce = True,
    max_size: options.LargestUpload = None,
    json_only: options.WrittenAsJson = False,
) -> None:
    """Lay a script and all it imports flat, ready to be uploaded.

    What will stop it on the testbed all the same, such as names of generation 1 of the API, is a
    warning. Exit code 0, or 2 with the reason and the way out where it cannot be laid flat.

    [bold]Examples[/bold]

        posflock bundle experiments/robotarium_9bot.py -o upload

        posflock bundle main.py -o upload --data goals.npy --no-run
    """
    from posflock_robotarium.submission.bundle import bundle as lay_flat
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

        say(json.dumps(ready.as_dict(), indent=1))
    else:
        _print_bundle(ready)


def _print_bundle(ready: "Bundle") -> None:
    from posflock_robotarium.submission.instructions import INSTRUCTIONS
    from posflock_robotarium.verify.findings import count

    size = max(1, round(ready.size / 1024))
    say(f"{count(len(ready.files), 'file')}, {size} KiB in {ready.folder}")
    if ready.left_out:
        names = (f"{name} ({library})" for name, library in sorted(ready.left_out.items()))
        say(f"left out, for libraries that the testbed has not: {', '.join(names)}")
    for warning in ready.warnings:
        say(f"warning: {warning}", err=True)
    say(f"main file {ready.main}; what to enter is in {ready.folder / INSTRUCTIONS}")


def rehearse(
    folder: options.Bundled,
    out: options.ReturnFolder = Path("rehearsal"),
    duration: options.DeclaredDuration = MAX_DURATION,
    profile: options.TestbedProfile = None,
    seed: options.TestbedSeed = 0,
    generation: options.Generation = 2,
    initial: options.TestbedInitial = "arrive",
    timeout: options.RealSeconds = 600.0,
    report: options.WithReport = True,
    json_only: options.OutcomeAsJson = False,
) -> None:
    """Run a bundle with the testbed's Python, libraries and folder, and without a network.

    The environment is built once and cached. Exit code 0 when the run ended by itself or by the
    declared duration, without a collision, and its files can be opened; 1 when not.

    [bold]Examples[/bold]

        posflock rehearse upload -o back --duration 320
    """
    from posflock_robotarium.submission.rehearse import rehearse as run
    from posflock_robotarium.submission.rehearse import report_on

    done = run(
        folder,
        out,
        duration=duration,
        profile=profile,
        seed=seed,
        generation=generation,
        initial=initial,
        timeout=timeout,
        tell=None if json_only else say,
    )
    page = report_on(done) if report else None
    if json_only:
        import json

        said = done.as_dict() | {"report": None if page is None else str(page)}
        say(json.dumps(said, indent=1))
    else:
        _print_rehearsal(done, page)
    raise typer.Exit(0 if done.passed else 1)


def _print_rehearsal(done: "Rehearsal", page: Path | None) -> None:
    from posflock_robotarium.verify.findings import count

    outcome, environment = done.outcome, done.environment
    why = f": {done.reason}" if done.reason else ""
    after = f" after {outcome.time:.1f} s" if outcome.time is not None else ""
    steps = f", {count(outcome.steps, 'step')}" if outcome.steps is not None else ""
    say(f"{outcome.ended}{after}{steps}{why}")
    versions = ", ".join(f"{name} {v}" for name, v in environment.libraries.items())
    say(f"environment: Python {environment.version}, {versions}; {done.containment.about}")
    if environment.note:
        say(f"note: {environment.note}")
    for name, found in done.files.items():
        say(f"  {name}: {found}")
    for violation in outcome.policy_violations:
        where = f"{violation.file}, line {violation.line}: " if violation.line else ""
        say(f"  {where}{violation.kind} ({violation.what})")
    ran = outcome.report
    if ran is not None and (not ran.clean or ran.steps_over_actuator_limits):
        say(f"  {ran.verdict}")
    if page is not None:
        say(f"report: {page}")
    say(f"what came back is in {done.folder}, with log.txt")
