"""Run any Robotarium script as it is: no changed byte, no display, nothing lost.

Around the script stand the :class:`RunSettings`: which generation ``import rps`` means, seeds,
imperfections, what is recorded and filmed. Headless, a simulated clock and a backend that draws on
demand let the script run as fast as it computes. However it ends, by itself, by an exception, by
Ctrl-C or by the time limit, the log is closed and a report written (see
`rps_compat.running.ending`).
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rps_compat.errors import ScriptError
from rps_compat.generations import Generation
from rps_compat.run_folder import asked_folder, claimed_folder, forget_report, forget_run
from rps_compat.run_settings import RunSettings
from rps_compat.running.driver import Guests, drive
from rps_compat.running.outcome import Outcome
from rps_compat.running.plan import ClockPolicy, RunPlan
from rps_compat.scripts.changes import Kind
from rps_compat.scripts.deaths import hint
from rps_compat.scripts.evidence import evidence_in
from rps_compat.surroundings import has_display


def run_script(
    script: Path, arguments: Sequence[str] = (), settings: RunSettings | None = None
) -> Outcome:
    """Run a script with its arguments and report how it went.

    An exception of the script does not pass: its traceback is printed to stderr, without our own
    frames, and the outcome says "failed". Threads of the script that are no daemons are waited for,
    as Python does; a run that is timed out, interrupted or hung may leave threads behind, which end
    with their next step. Nothing within a process can end them sooner.

    Parameters
    ----------
    script : Path
        The script's file.
    arguments : sequence of str
        What it finds in ``sys.argv[1:]``.
    settings : RunSettings, optional
        Everything else about the run.

    Raises
    ------
    ScriptError
        The script is not there, or the output folder cannot be written.
    UnreadableError
        The script is not Python.
    """
    settings = settings or RunSettings()
    script = Path(script).resolve()
    try:
        evidence = evidence_in(script)
    except ScriptError:
        if settings.claims_folder:
            forget_report(asked_folder(settings.out, script))
        raise
    generation = settings.generation or evidence.generation
    notes = evidence.notes(generation, found=settings.generation is None)
    if settings.tell is not None:
        for note in notes:
            settings.tell(note)
    guests = Guests(
        recorder=settings.recorder,
        tell=settings.tell,
        advise=lambda error: hint(error, evidence, generation),
        end_process=settings.end_process,
        notes=tuple(notes),
    )
    if settings.claims_folder:
        folder = claimed_folder(settings.out, script)
        forget_run(folder)
        settings = replace(settings, out=folder)
    return drive(_plan(script, arguments, generation, settings), guests)


def _plan(
    script: Path, arguments: Sequence[str], generation: Generation, settings: RunSettings
) -> RunPlan:
    headless = not has_display() if settings.headless is None else settings.headless
    profile = None
    if settings.profile is not None:
        from rps_compat.profiles import profile_to_dict

        profile = profile_to_dict(settings.profile)
    return RunPlan(
        script=str(script),
        folder=str(script.parent),
        generation=generation,
        arguments=tuple(arguments),
        initial=settings.initial,
        seed=settings.seed,
        script_seed=settings.seed,
        profile=profile,
        clock=ClockPolicy.SIMULATED if headless else ClockPolicy.REAL,
        draws_on_demand=headless,
        answers=tuple(settings.answers) if headless else None,
        bridges=(Kind.GONE.value, Kind.LATER.value),
        children=True,
        timeout=settings.timeout,
        out=None if settings.out is None else str(settings.out.resolve()),
        snapshots=tuple(settings.snapshots),
        video=None if settings.video is None else str(settings.video),
    )
