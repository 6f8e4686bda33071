"""Run a script in this process as a plan says, and tell how it went.

The script runs as ``__main__``, from its own folder and with its own arguments. Around it stands
what the plan asks for, entered one by one and left in turn, so that a process that is not the
script's own is afterwards as it was.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import runpy
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NoReturn

from rps_compat.bridges import bridge
from rps_compat.children.family import Family
from rps_compat.children.gathering import Children
from rps_compat.children.plan import Plan, hand_on
from rps_compat.clock import SimulatedClock
from rps_compat.clock.stand_ins import in_force
from rps_compat.errors import ScriptError
from rps_compat.film import Film
from rps_compat.process_state import hiding_notes, process_state
from rps_compat.recording import Onlooker, OpenRecorder, Recording
from rps_compat.repeatable import repeatable
from rps_compat.report import RunReport
from rps_compat.run_folder import REPORT_DATA, REPORT_TEXT
from rps_compat.running.ending import End, TimeLimit, end_of
from rps_compat.running.limits import limit_process
from rps_compat.running.measures import RunMeasures
from rps_compat.running.outcome import Ended, Outcome
from rps_compat.running.plan import ClockPolicy, RunPlan
from rps_compat.running.policy import Guard
from rps_compat.running.schedule import Schedule
from rps_compat.running.watching import Teller
from rps_compat.scripts.changes import Kind
from rps_compat.session import Session
from rps_compat.surroundings import answering, headless_matplotlib
from rps_compat.terminal import showable_output
from rps_compat.testbed import MAX_DURATION
from rps_compat.whole_files import sum_of, write_whole


@dataclass(frozen=True)
class Guests:
    """What takes part in a run and must be in its process; no plan can hold it.

    Attributes
    ----------
    recorder
        Opens the log of one instance; None writes no log.
    tell
        Is told notes before the script starts.
    advise
        Says what to try after an exception of the script, or None.
    end_process
        Is called in another thread, with the outcome, if the time limit cannot stop the script; it
        must end the process. None lets such a script run on.
    notes
        What is known of the script before it runs.
    teller
        Tells whoever watches from another process how far the run is, and what policy it violates.
    onlookers
        Look on in the script's own process.
    """

    recorder: OpenRecorder | None = None
    tell: Callable[[str], None] | None = None
    advise: Callable[[Exception], str | None] | None = None
    end_process: Callable[[Outcome], NoReturn] | None = None
    notes: tuple[str, ...] = ()
    teller: Teller | None = None
    onlookers: tuple[Onlooker, ...] = ()


def drive(plan: RunPlan, guests: Guests | None = None) -> Outcome:
    """Run a script in this process as a plan says.

    Parameters
    ----------
    plan : RunPlan
        What is run, and how.
    guests : Guests, optional
        What a plan cannot hold: objects that take part.

    Raises
    ------
    ScriptError
        The folder for what the run leaves cannot be written.
    ProfileError
        The plan's profile is none.
    """
    return _Run(plan, guests or Guests()).outcome()


class _Run:
    """One run, with everything that watches it."""

    def __init__(self, plan: RunPlan, guests: Guests) -> None:
        self.plan, self.guests = plan, guests
        self.script = Path(plan.folder) / plan.script
        self.out = None if plan.out is None else Path(plan.out)
        self.notes = list(guests.notes)
        self.window_notes: dict[str, None] = {}
        self.advice: str | None = None
        charged = plan.clock is ClockPolicy.CHARGED
        self.clock = (
            SimulatedClock(charge=True) if charged else SimulatedClock(longest_wait=MAX_DURATION)
        )
        self.measures = RunMeasures(self.clock) if plan.measures else None
        self.schedule = Schedule(plan, self._seconds, guests.teller)
        self.profile = None
        if plan.profile is not None:
            from rps_compat.profiles import profile_from_dict

            self.profile = profile_from_dict(plan.profile)
        self._make_folder()
        folder = self.out or Path.cwd()
        self.film = Film(plan.snapshots, folder, folder / plan.video if plan.video else None)
        self.recording = self._recording()
        self.session = self._session()
        self.family = Family(self._plan_of_children(), self.session, self.recording)
        self.guard = Guard(
            (str(self.script.parent), *plan.writable),
            self._time,
            plan.forbidden,
            plan.forbidden_to_libraries,
            None if guests.teller is None else guests.teller.violation,
        )

    # --- What watches ---------------------------------------------------------------------------

    def _make_folder(self) -> None:
        try:
            if self.out is not None:
                self.out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ScriptError(f"cannot write to {self.out}: {error.strerror or error}") from error

    def _recording(self) -> Recording:
        plan, schedule = self.plan, self.schedule
        about = {
            "script": self.script.name,
            "generation": plan.generation,
            "seed": plan.script_seed,
            "simulated": True,
            "profile": plan.profile_name,
        }
        with contextlib.suppress(OSError):  # that it cannot be read is told when it is run
            about["sha256"] = sum_of(self.script)
        scheduled = (plan.longest, plan.interrupt_at, plan.kill_at, self.guests.teller)
        listeners = [] if self.measures is None else [self.measures.step]
        if plan.measures or any(item is not None for item in scheduled):
            listeners.append(schedule.step)
        makers = [] if self.measures is None else [self.measures.created]
        return Recording(
            self.out,
            self.guests.recorder,
            about,
            self.film,
            listeners=listeners,
            makers=makers,
            onlookers=self.guests.onlookers,
            held=contextlib.nullcontext if plan.clock is ClockPolicy.REAL else self.clock.held,
        )

    def _session(self) -> Session:
        plan = self.plan
        simulated = None if plan.clock is ClockPolicy.REAL else self.clock
        return Session(
            initial=plan.initial,
            seed=plan.seed,
            realism=None if self.profile is None else self.profile.start,
            recorder=self.recording.watch,
            created=self.recording.created,
            wait=plan.wait,
            pace=self.measures or simulated,
        )

    def _seconds(self) -> float:
        return 0.0 if self.measures is None else self.measures.seconds

    def _time(self) -> float:
        """Seconds of the run, for what happens between two steps."""
        arenas = self.recording.arenas
        return self.schedule.steps * arenas[-1].robot.time_step if arenas else 0.0

    def _plan_of_children(self) -> Plan:
        """Tell the script's children, if it starts some afresh, what they need."""
        plan = self.plan
        handed, lost = hand_on(self.profile, self.guests.recorder) if plan.children else ("", "")
        return Plan(
            script=self.script.name,
            generation=plan.generation,
            seed=plan.script_seed,
            initial=plan.initial,
            headless=plan.draws_on_demand,
            out=plan.out,
            handed=handed,
            lost=lost,
        )

    # --- The run --------------------------------------------------------------------------------

    def outcome(self) -> Outcome:
        plan, guests = self.plan, self.guests
        with contextlib.ExitStack() as around:
            names = around.enter_context(
                process_state(
                    self.script,
                    (plan.script, *plan.arguments),
                    plan.generation,
                    plan.script_seed,
                    plan.path,
                    plan.keeps_apart,
                )
            )
            self._tell(hiding_notes(names))
            self._surround(around)
            give_up = None if guests.end_process is None else self._give_up
            self.limit = TimeLimit(plan.timeout, give_up)
            nothing = contextlib.nullcontext()
            left = self.family.ends_with_script() if plan.children else nothing
            end = self._as_scheduled(end_of(self._run_script, self.script, self.limit, left))
            if self.advice:
                print(self.advice, file=sys.stderr)
                self.notes.append(self.advice)
            if not self.family.is_home:  # a fork of the script has come to its end
                self.family.leave(end.ended.in_log, end.reason, end.exit_code)
            self.recording.over = True
            self.film.end(self.recording.first)
            self.notes += [note for note in hiding_notes(names) if note not in self.notes]
        return self._finish(self._idle_if_nothing_moved(end))

    def _surround(self, around: contextlib.ExitStack) -> None:
        """Enter what the plan wants around the script."""
        plan = self.plan
        around.enter_context(self.session.active())
        if plan.children:
            around.enter_context(self.family.at_home())
        around.enter_context(showable_output())
        around.enter_context(repeatable(plan.script_seed))
        if plan.bridges:
            bridge(around, *(Kind(kind) for kind in plan.bridges))
        if plan.measures:
            around.enter_context(self.schedule.listening())
        limit_process(plan.memory, plan.disk)
        if plan.clock is not ClockPolicy.REAL:
            around.enter_context(in_force(self.clock))
        if plan.draws_on_demand:
            self.window_notes = around.enter_context(headless_matplotlib())
        if plan.answers is not None:
            asked = self.guard.asked if plan.forbidden else None
            around.enter_context(answering(plan.answers, asked))
        if plan.forbidden:
            around.enter_context(self.guard.on_duty())

    def _tell(self, notes: list[str]) -> None:
        """Tell notes before the script starts, and keep them."""
        self.notes += notes
        if self.guests.tell is not None:
            for note in notes:
                self.guests.tell(note)

    def _run_script(self) -> None:
        try:
            runpy.run_path(self.plan.script, run_name="__main__")
        except Exception as error:
            if self.guests.advise is not None:
                self.advice = self.guests.advise(error)
            raise
        finally:
            if self.plan.exit_functions:
                atexit._run_exitfuncs()

    # --- Its end --------------------------------------------------------------------------------

    def _as_scheduled(self, end: End) -> End:
        """Return the end that was planned, whatever the script made of it."""
        schedule = self.schedule
        if schedule.seen_enough:  # a `finally:` may fail on what the script had no time to make
            return End.of(Ended.STOPPED)
        if schedule.over_time:
            reason = f"still running after {schedule.time:.1f} s"
            return End.of(Ended.OVER_TIME, reason, end.error)
        if schedule.interrupted and end.ended is Ended.FINISHED:
            return End.of(Ended.INTERRUPTED, "KeyboardInterrupt")
        return end

    def _give_up(self) -> None:
        assert self.guests.end_process is not None
        self.recording.over = True
        self.family.end_children()
        self.guests.end_process(self._finish(self.limit.end))

    def _idle_if_nothing_moved(self, end: End) -> End:
        if self.plan.measures:  # whoever measures is told of the steps
            return end
        arenas = self.recording.arenas
        moved = any(arena.steps > arena.steps_to_start for arena in arenas)
        if moved or self.family.children.reports or not arenas or end.ended is not Ended.FINISHED:
            return end
        return End.of(Ended.IDLE, "a Robotarium was made and never stepped: nothing would move")

    def _notes_on_time(self) -> list[str]:
        """Note what kept the real time, and animations that were cut."""
        real = ", ".join(self.clock.real_reasons)
        notes = [f"in real time, since it cannot be simulated: {real}"] if real else []
        return [*notes, *self.window_notes]

    def _finish(self, end: End) -> Outcome:
        plan = self.plan
        children = self.family.children if plan.children else Children()
        reports = (*self.recording.reports(), *children.reports)
        logs = self.recording.close(end.ended.in_log, end.reason)
        outcome = Outcome(
            self.script,
            plan.generation,
            end.ended,
            end.reason,
            end.exit_code,
            reports,
            (*self.film.files, *logs, *children.files),
            (*self.notes, *_notes_on(reports), *self._notes_on_time(), *children.notes),
            self.out,
            end.error,
            name=plan.name,
            seed=plan.seed,
            profile=plan.profile_name,
            policy_violations=tuple(self.guard.violations),
        )
        outcome = self._measured(outcome)
        return outcome if self.out is None else _written(outcome, self.out)

    def _measured(self, outcome: Outcome) -> Outcome:
        arenas = self.recording.arenas
        outcome = replace(outcome, time=arenas[-1].time if arenas else 0.0)
        if self.measures is None:
            return replace(outcome, steps=sum(arena.steps for arena in arenas))
        told = self.measures.told_in(outcome)
        return replace(told, steps=self.schedule.steps, finishing_call=self.schedule.finished)


def _written(outcome: Outcome, out: Path) -> Outcome:
    """Write the report into the folder `out`, as text and as data, with the sums of all files."""
    text, data = out / REPORT_TEXT, out / REPORT_DATA
    outcome = replace(outcome, files=(*outcome.files, text, data))
    reports = "\n".join(report.text(outcome.generation) for report in outcome.reports)
    write_whole(text, reports)
    told = outcome.as_dict()
    told["sums"] = {path.name: sum_of(path) for path in outcome.files[:-1] if path.is_file()}
    write_whole(data, json.dumps(told, indent=1) + "\n")
    return outcome


def _notes_on(reports: tuple[RunReport, ...]) -> tuple[str, ...]:
    """Note what the testbed does not take, once each, and a run in which nothing ran."""
    if not reports:
        return ("no Robotarium was made: there is nothing to report on",)
    return tuple(dict.fromkeys(note for report in reports for note in report.notes))
