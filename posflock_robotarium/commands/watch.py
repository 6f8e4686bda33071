"""``posflock watch``: a running simulation in the browser."""

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from posflock_robotarium.commands import options, watch_options
from posflock_robotarium.commands.terminal import say

if TYPE_CHECKING:
    from posflock_robotarium.watch.script import WatchJob
    from posflock_robotarium.watch.serving import Place
    from rps_compat.generations import Generation

#: As a shell has it, of a program that Ctrl-C ended.
INTERRUPTED = 130


def watch(
    context: typer.Context,
    script: options.ScriptAndArguments,
    generation: options.FoundGeneration = None,
    initial: options.Initial = "published",
    seed: options.ScriptSeed = None,
    profile: options.Profile = "ideal",
    speed: watch_options.WatchSpeed = "1",
    paused: watch_options.StartPaused = False,
    radius: watch_options.WatchRadius = None,
    answer: options.Answers = None,
    port: watch_options.Port = 0,
    open_page: watch_options.OpenPage = None,
    stay: watch_options.Stay = True,
    out: watch_options.WatchFolder = None,
) -> None:
    """Show a running simulation in the browser: hold it, step it, change what it runs under.

    Robots, trails, neighbours, what barrier certificates do; pause, steps, speed, the robots'
    imperfections, and of our flock the law. The page is served to this machine alone, under an
    address that nobody can guess; SSH forwards it by the line that is printed. The script runs from
    a copy, in the containment of verify. Ctrl-C ends all; the exit code is the script's own.

    [bold]Examples[/bold]

        posflock watch experiments/robotarium_9bot.py

        posflock watch --profile gritsbot_x --speed 4 --port 8765 --no-open formation.py
    """
    from posflock_robotarium.watch.serving import require_library
    from posflock_robotarium.watch.serving import watch as show
    from posflock_robotarium.watch.settings import Settings
    from rps_compat.run_folder import claimed_folder, forget_run
    from rps_compat.running.outcome import summary

    require_library()
    settings = Settings(_factor(speed), paused, profile)
    job = _job(script, tuple(context.args), generation, initial, seed, profile, radius, answer)
    for note in job.notes:
        say(f"{script}: {note}", err=True)
    if out is not None:
        forget_run(claimed_folder(out, job.script))
    outcome = show(
        job,
        settings,
        port=port,
        out=out,
        stay=stay,
        opens=_sees_a_browser() if open_page is None else open_page,
        tell=_tell,
        say=lambda text: say(text, end=""),
        ended=lambda outcome: say(summary(outcome)),
    )
    raise typer.Exit(INTERRUPTED if outcome is None else outcome.exit_code)


def _job(
    script: Path,
    arguments: tuple[str, ...],
    generation: int | None,
    initial: str,
    seed: int | None,
    profile: str,
    radius: float | None,
    answers: list[str] | None,
) -> "WatchJob":
    """Return what is run, with all profiles that a page may choose."""
    from posflock_robotarium.flocking.errors import ParameterError
    from posflock_robotarium.watch.script import WatchJob
    from rps_compat.profiles import NAMES, load_profile
    from rps_compat.run_settings import RunSettings
    from rps_compat.scripts.evidence import evidence_in
    from rps_compat.session import Session

    if radius is not None and not radius > 0:
        raise ParameterError(f"--radius: expected more than 0 m, got {radius:g}")
    RunSettings(seed=seed)  # refuses a seed that is none
    chosen = Session(initial=initial)  # type: ignore[arg-type]  # refuses a way that is none
    script = script.resolve()
    evidence = evidence_in(script)
    api: Generation = evidence.generation
    if generation is not None:
        api = 1 if generation == 1 else 2
    return WatchJob(
        script=script,
        generation=api,
        profiles={name: load_profile(name) for name in dict.fromkeys((*NAMES, profile))},
        arguments=arguments,
        initial=chosen.initial,
        seed=seed,
        answers=tuple(answers or ()),
        radius=radius,
        notes=tuple(evidence.notes(api, found=generation is None)),
    )


def _factor(word: str) -> float | None:
    """Read a speed: how many times as fast as real time, or None for ``max``."""
    from posflock_robotarium.watch.requests import SPEEDS, RequestError

    speeds = {"max" if speed is None else f"{speed:g}": speed for speed in SPEEDS}
    if word not in speeds:
        raise RequestError(f"--speed: expected one of {', '.join(speeds)}; got {word!r}")
    return speeds[word]


def _sees_a_browser() -> bool:
    """Whether somebody sits at this machine, in front of a display."""
    import os

    from rps_compat.surroundings import has_display

    return has_display() and "SSH_CONNECTION" not in os.environ


def _tell(place: "Place") -> None:
    say(f"watch it at {place.url}")
    say(f"on another machine, first run there: {place.forwarding}")
    say("Ctrl-C here ends script and page")
