"""Run any Robotarium script as it is: no changed byte, no display, nothing lost.

The script runs as ``__main__``, from its own folder and with its own arguments, in this process.
Around it stand the :class:`RunSettings`: which generation ``import rps`` means, seeds,
imperfections, what is recorded and filmed. Headless, a simulated clock and a backend that draws on
demand let the script run as fast as it computes. However it ends, by itself, by an exception, by
Ctrl-C or by the time limit, the log is closed and a report written (see `rps_compat.ending`).
"""

import contextlib
import json
import runpy
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rps_compat.bridges import dropped_names, one_element_conversions
from rps_compat.children.family import Family
from rps_compat.children.plan import Plan, hand_on
from rps_compat.clock import SimulatedClock
from rps_compat.ending import LOGGED, End, TimeLimit, end_of
from rps_compat.errors import ScriptError
from rps_compat.film import Film
from rps_compat.generations import Generation
from rps_compat.process_state import hiding_notes, process_state
from rps_compat.recording import Recording
from rps_compat.repeatable import repeatable
from rps_compat.report import TESTBED_SECONDS, RunReport
from rps_compat.run_result import RunResult
from rps_compat.run_settings import RunSettings
from rps_compat.scripts.changes import Kind
from rps_compat.scripts.deaths import hint
from rps_compat.scripts.evidence import Evidence, evidence_in
from rps_compat.session import Session
from rps_compat.surroundings import answering, has_display, headless_matplotlib
from rps_compat.terminal import showable_output


def run_script(
    script: Path, arguments: Sequence[str] = (), settings: RunSettings | None = None
) -> RunResult:
    """Run `script` with `arguments` and report how it went.

    An exception of the script does not pass: its traceback is printed to stderr, without our own
    frames, and the result says "failed". Threads of the script that are no daemons are waited for,
    as Python does; a run that ends by "timeout", "interrupted" or "stuck" may leave threads behind,
    which end with their next step. Nothing within a process can end them sooner.

    Raises
    ------
    ScriptError
        The script is not there, or the output folder cannot be written.
    UnreadableError
        The script is not Python.
    """
    settings = settings or RunSettings()
    script = Path(script).resolve()
    evidence = evidence_in(script)
    generation = settings.generation or evidence.generation
    notes = evidence.notes(generation, found=settings.generation is None)
    if settings.tell is not None:
        for note in notes:
            settings.tell(note)
    return _Run(script, list(arguments), generation, settings, notes, evidence).result()


@dataclass
class _Run:
    script: Path
    arguments: list[str]
    generation: Generation
    settings: RunSettings
    notes: list[str]
    evidence: Evidence
    clock: SimulatedClock = field(
        default_factory=lambda: SimulatedClock(longest_wait=TESTBED_SECONDS)
    )
    window_notes: dict[str, None] = field(default_factory=dict)
    advice: str | None = None

    def result(self) -> RunResult:
        settings = self.settings
        self.headless = not has_display() if settings.headless is None else settings.headless
        self.out = None if settings.out is None else settings.out.resolve()
        try:
            if self.out is not None:
                self.out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ScriptError(f"cannot write to {self.out}: {error.strerror or error}") from error
        folder = self.out or Path.cwd()
        video = folder / settings.video if settings.video else None
        self.film = Film(settings.snapshots, folder, video)
        about = {"script": self.script.name, "generation": self.generation, "seed": settings.seed}
        self.recording = Recording(self.out, settings.recorder, about, self.film)
        session = Session(
            initial=settings.initial,
            seed=settings.seed,
            realism=None if settings.profile is None else settings.profile.start,
            recorder=self.recording.watch,
            created=self.recording.created,
            pace=self.clock if self.headless else None,
        )
        self.family = Family(self._plan(), session, self.recording)
        with contextlib.ExitStack() as around:
            names = around.enter_context(
                process_state(self.script, self.arguments, self.generation, settings.seed)
            )
            self._tell(hiding_notes(names))
            around.enter_context(session.active())
            around.enter_context(self.family.at_home())
            around.enter_context(showable_output())
            around.enter_context(repeatable(settings.seed))
            around.enter_context(dropped_names(Kind.GONE, Kind.LATER))
            around.enter_context(one_element_conversions())
            if self.headless:
                around.enter_context(self.clock.in_force())
                self.window_notes = around.enter_context(headless_matplotlib())
                around.enter_context(answering(settings.answers))
            self.limit = TimeLimit(
                settings.timeout, self._give_up if settings.end_process else None
            )
            end = end_of(self._run_script, self.script, self.limit, self.family.ends_with_script())
            if self.advice:
                print(self.advice, file=sys.stderr)
                self.notes.append(self.advice)
            if not self.family.is_home:  # a fork of the script has come to its end
                self.family.leave(LOGGED.get(end.ended, end.ended), end.reason, end.exit_code)
            self.recording.over = True
            self.film.end(self.recording.first)
            self.notes += [note for note in hiding_notes(names) if note not in self.notes]
        return self._finish(self._idle_if_nothing_moved(end))

    def _plan(self) -> Plan:
        """Tell the script's children, if it starts some afresh, what they need."""
        settings = self.settings
        handed, lost = hand_on(settings.profile, settings.recorder)
        return Plan(
            script=self.script.name,
            generation=self.generation,
            seed=settings.seed,
            initial=settings.initial,
            headless=self.headless,
            out=None if self.out is None else str(self.out),
            handed=handed,
            lost=lost,
        )

    def _tell(self, notes: list[str]) -> None:
        """Tell notes before the script starts, and keep them."""
        self.notes += notes
        if self.settings.tell is not None:
            for note in notes:
                self.settings.tell(note)

    def _run_script(self) -> None:
        try:
            runpy.run_path(str(self.script), run_name="__main__")
        except Exception as error:
            self.advice = hint(error, self.evidence, self.generation)
            raise

    def _give_up(self) -> None:
        assert self.settings.end_process is not None
        self.recording.over = True
        self.family.end_children()
        self.settings.end_process(self._finish(self.limit.end))

    def _idle_if_nothing_moved(self, end: End) -> End:
        arenas = self.recording.arenas
        moved = any(arena.steps > arena.steps_to_start for arena in arenas)
        if moved or self.family.children.reports or not arenas or end.ended != "finished":
            return end
        return End.of("idle", "a Robotarium was made and never stepped: nothing would move")

    def _notes_on_time(self) -> list[str]:
        """Note what kept the real time, and animations that were cut."""
        real = ", ".join(self.clock.real_reasons)
        notes = [f"in real time, since it cannot be simulated: {real}"] if real else []
        return [*notes, *self.window_notes]

    def _finish(self, end: End) -> RunResult:
        children = self.family.children
        reports = (*self.recording.reports(), *children.reports)
        logs = self.recording.close(LOGGED.get(end.ended, end.ended), end.reason)
        texts = () if self.out is None else (self.out / "report.txt", self.out / "report.json")
        result = RunResult(
            self.script,
            self.generation,
            end.ended,
            end.reason,
            end.exit_code,
            reports,
            (*self.film.files, *logs, *children.files, *texts),
            (*self.notes, *_notes_on(reports), *self._notes_on_time(), *children.notes),
            self.out,
        )
        if texts:
            text, data = texts
            text.write_text("\n".join(report.text(self.generation) for report in reports), "utf-8")
            data.write_text(json.dumps(result.as_dict(), indent=1) + "\n", "utf-8")
        return result


def _notes_on(reports: tuple[RunReport, ...]) -> tuple[str, ...]:
    """Note what the testbed does not take, once each, and a run in which nothing ran."""
    if not reports:
        return ("no Robotarium was made: there is nothing to report on",)
    return tuple(dict.fromkeys(note for report in reports for note in report.notes))
