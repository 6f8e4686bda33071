"""Run any Robotarium script as it is: no changed byte, no display, nothing lost.

The script runs as ``__main__``, from its own folder and with its own arguments, in this process.
Around it stand the :class:`RunSettings`: which generation ``import rps`` means, seeds,
imperfections, what is recorded and filmed. Headless, a simulated clock and a backend that draws on
demand let the script run as fast as it computes. However it ends, by itself, by an exception, by
Ctrl-C or by the time limit, the log is closed and a report written.
"""

import contextlib
import json
import math
import os
import random
import runpy
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np

from rps_compat.arena import Arena, Array, Realism
from rps_compat.bridges import dropped_names, one_element_conversions
from rps_compat.clock import SimulatedClock
from rps_compat.errors import RobotariumError, ScriptError
from rps_compat.film import Film
from rps_compat.install import Api, install, installed, uninstall
from rps_compat.repeatable import repeatable
from rps_compat.report import RunReport, report_on
from rps_compat.scripts.changes import Kind
from rps_compat.scripts.deaths import hint
from rps_compat.scripts.evidence import Evidence, evidence_in
from rps_compat.session import Initial, Session
from rps_compat.surroundings import (
    OutOfTime,
    answering,
    forget_modules_of,
    has_display,
    headless_matplotlib,
    time_limit,
)
from rps_compat.terminal import showable_output

Ended = Literal["finished", "failed", "interrupted", "timeout"]
#: Exit codes of a run that the script does not end itself, as shells have them.
EXIT_CODES: dict[Ended, int] = {"finished": 0, "failed": 1, "interrupted": 130, "timeout": 124}


class SettingsError(RobotariumError, ValueError):
    """A time limit, a snapshot's time or a seed outside its range."""


class RunRecorder(Protocol):
    """A recorder that is told how the run ended; the pose log is one."""

    def append(self, time: float, poses: Array, commands: Array, /) -> None:
        """Take note of one step."""

    def close(self, how: str, reason: str, /) -> None:
        """Take note of the end."""


#: Makes the recorder of one instance: where (without ending), for how many robots, and what is
#: known about the run.
OpenRecorder = Callable[[Path, int, dict[str, Any]], RunRecorder]


@dataclass(frozen=True)
class RunSettings:
    """Everything about a run that is not in the script.

    Attributes
    ----------
    api
        Generation of the API; None finds it from the script's source.
    headless
        No window, no waiting; None: headless where there is no display.
    initial
        How robots come to their initial conditions; see `rps_compat.session.Session`.
    seed
        Seeds Python's and numpy's global generators, and the imperfections.
    realism
        Makes the imperfections of one instance; None is the ideal arena.
    timeout
        Seconds of real time after which the script is stopped; None lets it run.
    answers
        What ``input()`` answers headless, in order; after them an empty line.
    out
        Folder for everything that the run leaves; made if need be. None leaves nothing.
    snapshots
        Times of the run in seconds at which the figure is saved; infinity is its end.
    video
        File to film to, .mp4 or .gif; a relative name lies in `out`.
    recorder
        Opens the log of one instance; None writes no log.
    tell
        Is told, before the script starts, each note on the generation that it runs on.

    Raises
    ------
    SettingsError
        A time limit that is not positive, a snapshot before the start, or a negative seed.
    """

    api: Api | None = None
    headless: bool | None = None
    initial: Initial = "published"
    seed: int | None = None
    realism: Callable[[], Realism | None] | None = None
    timeout: float | None = None
    answers: Sequence[str] = ()
    out: Path | None = None
    snapshots: Sequence[float] = ()
    video: Path | None = None
    recorder: OpenRecorder | None = None
    tell: Callable[[str], None] | None = None

    def __post_init__(self) -> None:
        if self.timeout is not None and not self.timeout > 0:
            raise SettingsError(
                f"timeout is {self.timeout:g} s, expected more than 0; leave it out for none"
            )
        for time in self.snapshots:
            if not time >= 0:
                raise SettingsError(
                    f"snapshot at {time:g} s, expected 0 or more seconds of the run, or its end"
                )
        if self.seed is not None and self.seed < 0:
            raise SettingsError(f"seed is {self.seed}, expected a whole number from 0")


@dataclass(frozen=True)
class RunResult:
    """How a run went.

    Attributes
    ----------
    script
        The script that ran.
    api
        The generation that it ran on.
    ended
        "finished", "failed" (an exception), "interrupted" (Ctrl-C) or "timeout".
    reason
        In words, for everything but "finished".
    exit_code
        For the shell: the script's own, or one of `EXIT_CODES`.
    reports
        One for each Robotarium instance, in the order of their making.
    files
        What the run left in its folder.
    notes
        What is no fault of the run, and yet to be known before the testbed.
    folder
        Where the run left its files; None if nowhere.
    """

    script: Path
    api: Api
    ended: Ended
    reason: str
    exit_code: int
    reports: tuple[RunReport, ...]
    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()
    folder: Path | None = None

    @property
    def clean(self) -> bool:
        """Whether the run finished and nothing would have stopped it on the testbed."""
        return self.exit_code == 0 and all(report.clean for report in self.reports)

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain data, ready for JSON.

        Files are told relative to the folder, so that equal runs into two folders are equal.
        """
        return {
            "script": str(self.script),
            "api": self.api,
            "ended": self.ended,
            "reason": self.reason,
            "exit_code": self.exit_code,
            "clean": self.clean,
            "notes": list(self.notes),
            "reports": [report.as_dict() for report in self.reports],
            "files": [self._relative(path) for path in self.files],
        }

    def as_json(self) -> str:
        """Return the result and its folder as JSON: for a program that started the run."""
        folder = None if self.folder is None else str(self.folder)
        return json.dumps({**self.as_dict(), "folder": folder}, indent=1)

    def _relative(self, path: Path) -> str:
        if self.folder is not None and path.is_relative_to(self.folder):
            return path.relative_to(self.folder).as_posix()
        return str(path)


def run_script(
    script: Path, arguments: Sequence[str] = (), settings: RunSettings | None = None
) -> RunResult:
    """Run `script` with `arguments` and report how it went.

    An exception of the script does not pass: its traceback is printed to stderr, without our own
    frames, and the result says "failed".

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
    api = settings.api or evidence.generation
    notes = evidence.notes(api, found=settings.api is None)
    if settings.tell is not None:
        for note in notes:
            settings.tell(note)
    return _Run(script, list(arguments), api, settings, notes, evidence).result()


class _Watch:
    """Recorder of one instance: passes each step on to log, film and clock."""

    def __init__(self, run: "_Run", log: RunRecorder | None) -> None:
        self._run, self.log, self._before = run, log, 0.0
        self.instance: Any = None

    def append(self, time: float, poses: Array, commands: Array) -> None:
        # The step that begins now takes its time, whatever else the script does in it.
        end = time + (self.instance._arena.robot.time_step if self.instance else 0.0)
        self._run.clock.advance(end - self._before)
        self._before = end
        if self.log is not None:
            self.log.append(time, poses, commands)
        film = self._run.film
        if not film.idle and self._run.watches[0] is self:
            film.at(time, self.instance)


@dataclass
class _Run:
    script: Path
    arguments: list[str]
    api: Api
    settings: RunSettings
    notes: list[str]
    evidence: Evidence
    clock: SimulatedClock = field(default_factory=SimulatedClock)
    watches: list[_Watch] = field(default_factory=list)
    logs: list[Path] = field(default_factory=list)

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
        session = Session(
            initial=settings.initial,
            seed=settings.seed,
            realism=settings.realism,
            recorder=self._watch,
            created=self._created,
            wait=False if self.headless else None,
        )
        with contextlib.ExitStack() as around:
            around.enter_context(self._process_state())
            around.enter_context(session.active())
            around.enter_context(showable_output())
            around.enter_context(repeatable(settings.seed))
            around.enter_context(dropped_names(Kind.GONE, Kind.LATER))
            around.enter_context(one_element_conversions())
            if self.headless:
                around.enter_context(self.clock.in_force())
                around.enter_context(headless_matplotlib())
                around.enter_context(answering(settings.answers))
            ended, reason, exit_code = self._execute()
            self.film.end(self.watches[0].instance if self.watches else None)
        return self._finish(ended, reason, exit_code)

    def _watch(self, robots: int) -> _Watch:
        log = None
        if self.settings.recorder is not None and self.out is not None:
            number = len(self.watches) + 1
            path = self.out / ("poses" if number == 1 else f"poses-{number}")
            about = {"script": self.script.name, "api": self.api, "seed": self.settings.seed}
            log = self.settings.recorder(path, robots, about)
            self.logs.append(path)
        watch = _Watch(self, log)
        self.watches.append(watch)
        return watch

    def _created(self, instance: Any) -> None:
        watch = instance._arena.recorder
        if isinstance(watch, _Watch):
            watch.instance = instance

    @contextlib.contextmanager
    def _process_state(self) -> Iterator[None]:
        """Be where the script expects to be, and leave the process as it was."""
        folder, argv, path = Path.cwd(), sys.argv, list(sys.path)
        bytecode, api, modules = sys.dont_write_bytecode, installed(), set(sys.modules)
        randomness = random.getstate(), np.random.get_state()  # noqa: NPY002
        os.chdir(self.script.parent)
        sys.argv = [str(self.script), *self.arguments]
        sys.path.insert(0, str(self.script.parent))
        sys.dont_write_bytecode = True  # the script's folder is not ours to write to
        install(self.api)
        if self.settings.seed is not None:
            random.seed(self.settings.seed)
            np.random.seed(self.settings.seed % 2**32)  # noqa: NPY002 - what scripts draw from
        try:
            yield
        finally:
            os.chdir(folder)
            sys.argv, sys.path[:], sys.dont_write_bytecode = argv, path, bytecode
            random.setstate(randomness[0])
            np.random.set_state(randomness[1])  # noqa: NPY002
            uninstall() if api is None else install(api)
            forget_modules_of(self.script.parent, modules)

    def _execute(self) -> tuple[Ended, str, int]:
        try:
            with time_limit(self.settings.timeout):
                runpy.run_path(str(self.script), run_name="__main__")
        except SystemExit as left:
            return _exit_of(left)
        except OutOfTime:
            limit = self.settings.timeout
            reason = f"stopped by the time limit of {limit:g} s"
            return "timeout", reason, EXIT_CODES["timeout"]
        except KeyboardInterrupt:
            return "interrupted", "KeyboardInterrupt", EXIT_CODES["interrupted"]
        except BaseException as error:
            _print_traceback(error, self.script)
            advice = hint(error, self.evidence, self.api)
            if advice:
                print(advice, file=sys.stderr)
                self.notes.append(advice)
            return "failed", f"{type(error).__name__}: {error}", EXIT_CODES["failed"]
        return "finished", "", 0

    def _finish(self, ended: Ended, reason: str, exit_code: int) -> RunResult:
        arenas: list[Arena] = [w.instance._arena for w in self.watches if w.instance is not None]
        reports = tuple(report_on(arena) for arena in arenas)
        files = list(self.film.files)
        for watch, path in zip(
            (w for w in self.watches if w.log is not None), self.logs, strict=True
        ):
            assert watch.log is not None
            watch.log.close("interrupted" if ended == "timeout" else ended, reason)
            files += sorted(path.parent.glob(f"{path.name}.*"))
        texts = () if self.out is None else (self.out / "report.txt", self.out / "report.json")
        result = RunResult(
            self.script,
            self.api,
            ended,
            reason,
            exit_code,
            reports,
            (*files, *texts),
            (*self.notes, *_notes_on(reports)),
            self.out,
        )
        if texts:
            text, data = texts
            text.write_text("\n".join(report.text(self.api) for report in reports), "utf-8")
            data.write_text(json.dumps(result.as_dict(), indent=1) + "\n", "utf-8")
        return result


def _notes_on(reports: tuple[RunReport, ...]) -> tuple[str, ...]:
    """Note what the testbed does not take, once each, and a run in which nothing ran."""
    if not reports:
        return ("no Robotarium was made: there is nothing to report on",)
    return tuple(dict.fromkeys(note for report in reports for note in report.notes))


def _exit_of(left: SystemExit) -> tuple[Ended, str, int]:
    if left.code is None or left.code == 0:
        return "finished", "", 0
    if isinstance(left.code, int):
        return "failed", f"the script left with exit code {left.code}", left.code
    print(left.code, file=sys.stderr)
    return "failed", str(left.code), 1


def _print_traceback(error: BaseException, script: Path) -> None:
    frames = error.__traceback__
    while frames is not None and frames.tb_frame.f_code.co_filename != str(script):
        frames = frames.tb_next
    traceback.print_exception(type(error), error, frames or error.__traceback__)


def summary(result: RunResult) -> str:
    """Tell in a few lines how a run went and what it left: for a terminal."""
    lines = [f"{result.script.name}: generation {result.api}, {result.ended}"]
    if result.reason:
        lines[0] += f" ({result.reason})"
    for number, report in enumerate(result.reports, start=1):
        which = f"Robotarium {number}: " if len(result.reports) > 1 else ""
        lines.append(
            f"{which}{report.number_of_robots} robots, {report.steps} steps, "
            f"{report.duration:.1f} s on the testbed, {report.verdict}"
        )
        lines += [f"  {fault}" for fault in report.faults[:5] if fault.kind != "actuator"]
    lines += [f"note: {note}" for note in result.notes]
    if result.files:
        folders = sorted({str(path.parent) for path in result.files})
        names = ", ".join(path.name for path in result.files)
        lines.append(f"in {', '.join(folders)}: {names}")
    return "\n".join(lines)


def snapshot_times(text: str) -> tuple[float, ...]:
    """Read the times of ``--snapshot``: seconds with commas between, ``end`` for the end.

    Raises
    ------
    ScriptError
        Something else is written there.
    """
    try:
        return tuple(
            math.inf if word.strip() == "end" else float(word) for word in text.split(",") if word
        )
    except ValueError:
        raise ScriptError(f"--snapshot {text}: expected seconds, e.g. 0,10,end") from None
