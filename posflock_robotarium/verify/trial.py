"""One trial: a script run once in a process of its own, watched, limited and recorded.

The process was forked for this trial and ends with it.  The script sees the testbed's world: it
is ``__main__``, has no arguments, finds its files flat in the working folder, and ``rps`` is the
simulator under the trial's imperfections.  Its time is a :class:`SimulatedClock` that charges it
for what it computes, and :mod:`~.guard` stops what it must not do.
"""

from __future__ import annotations

import builtins
import contextlib
import json
import math
import mmap
import os
import resource
import runpy
import signal
import struct
import sys
import traceback
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.ties import beyond, first_smallest, reached, short_of
from posflock_robotarium import testbed
from posflock_robotarium.verify.guard import Guard
from rps_compat.clock import SimulatedClock, Stuck, real

_PULSE = struct.Struct("qddd")


@dataclass(frozen=True)
class TrialPlan:
    """What to run, and how; JSON holds it.

    Attributes
    ----------
    name : str
        Such as ``realism-07``.
    script : str
        The main file, in `scratch`.
    scratch : str
        Working folder, this trial's own.
    results : str
        Folder for what is said about the trial.
    path : tuple of str
        Further folders to import from.
    generation : int
        Of the API, 1 or 2.
    initial : str
        How the robots come to their initial conditions: exact, arrive or drive.
    seed : int
        Of imperfections and arrival, and of numpy's and Python's global streams.
    profile : dict
        Realism profile as a table; empty is ideal.
    longest : float
        Seconds of the run after which the testbed would interrupt it.
    interrupt_at, kill_at : float, optional
        Seconds of the run at which to raise KeyboardInterrupt in ``step()``, or to kill.
    only_start : bool
        Whether enough has been seen when the robots are at their initial conditions.
    memory : int
        Bytes it may allocate.
    """

    name: str
    script: str
    scratch: str
    results: str
    path: tuple[str, ...] = ()
    generation: int = 2
    initial: str = "exact"
    seed: int = 0
    profile: dict[str, Any] = field(default_factory=dict)
    longest: float = testbed.MAX_DURATION
    interrupt_at: float | None = None
    kill_at: float | None = None
    only_start: bool = False
    memory: int = 2 << 30


@dataclass
class Outcome:
    """What became of a trial; JSON holds it.

    Times are seconds of the run, distances metres; a step is one call of ``step()``.

    Attributes
    ----------
    ended : str
        finished, crashed, exited (with a code that says failure), interrupted (as planned),
        over-time (ran until the longest time), stopped (as planned, enough seen), killed (as
        planned), hung (stopped stepping), memory, died (by a signal).
    error : dict
        ``type``, ``message``, ``missing`` (a file that it reads), ``line``, ``file``, ``lines``
        (of the script, in the traceback).
    policy_violations : list of dict
        What policy forbids: ``kind`` (a finding's code), ``what``, ``line``, ``time``.
    events : list
        Faults: kind, robots, first and last step, worst value.
    """

    name: str
    ended: str = "died"
    error: dict[str, Any] = field(default_factory=dict)
    robots: int = 0
    generation: int = 0
    time_step: float = testbed.TIME_STEP
    steps: int = 0
    time: float = 0.0
    clock: float = 0.0
    events: list[Any] = field(default_factory=list)
    close_pairs: int = 0
    outside_steps: int = 0
    actuator_steps: int = 0
    largest_wheel: float = 0.0
    smallest_gap: dict[str, Any] = field(default_factory=dict)
    wall_gap: dict[str, Any] = field(default_factory=dict)
    initial_gap: dict[str, Any] = field(default_factory=dict)
    loop: dict[str, float] = field(default_factory=dict)
    silent: dict[str, float] = field(default_factory=dict)
    policy_violations: list[dict[str, Any]] = field(default_factory=list)
    files: dict[str, int] = field(default_factory=dict)
    finishing_call: bool = False
    said: str = ""
    seed: int = 0
    profile: str = ""


class Enough(BaseException):
    """The trial has seen what it was for."""


class Watch:
    """Sees every step: times it, measures the gaps, and ends the run where the plan says so."""

    def __init__(self, plan: TrialPlan, pulse: mmap.mmap, clock: SimulatedClock) -> None:
        self.plan = plan
        self.clock = clock
        self.seconds = 0.0
        self._left = 0.0
        self.arenas: list[Any] = []
        self.loops: list[float] = []
        self.smallest_gap: tuple[float, float, tuple[int, int]] = (np.inf, 0.0, (0, 0))
        self.initial_gap = self.smallest_gap
        self.wall_gap: tuple[float, float, int] = (np.inf, 0.0, 0)
        self.silent = (0.0, 0.0)
        self._silence = 0.0
        self._pulse = pulse
        self._steps = 0
        self._refusals = 0
        self._interrupted = False
        self.over_time = False
        self.seen_enough = False
        self.finished = False

    def created(self, robotarium: Any) -> None:
        """Take note of a Robotarium that the script made."""
        arena = robotarium._arena
        self.arenas.append(arena)
        if len(self.arenas) == 1:
            self._measure(0.0, arena)
            self.initial_gap = self.smallest_gap
        self.clock.resume()

    def append(self, t: float, poses: NDArray[np.float64], commands: NDArray[np.float64]) -> None:
        """Be told of a step, before the robots move: called inside the script's ``step()``."""
        arena, plan = self.arenas[-1], self.plan
        spent = self.clock.spent()
        if self._steps:
            self.loops.append(spent)
        self.clock.resume()
        self._left = max(arena.robot.time_step - spent, 0.0)
        self.seconds += spent + self._left
        self._measure(t, arena)
        self._hear(t, arena)
        self._steps += 1
        self._pulse[: _PULSE.size] = _PULSE.pack(self._steps, t, real.time(), real.process_time())
        if plan.kill_at is not None and reached(t, plan.kill_at):
            os.kill(os.getpid(), signal.SIGKILL)
        interrupt = math.inf if plan.interrupt_at is None else plan.interrupt_at
        if reached(t, interrupt) and not self._interrupted:
            self._interrupted = True
            raise KeyboardInterrupt
        if reached(max(self.seconds, t), plan.longest):
            self.over_time = True
            self._refusals += 1
            raise KeyboardInterrupt if self._refusals < 10 else Enough

    def _measure(self, t: float, arena: Any) -> None:
        poses = arena.poses
        points = poses[0] + 1j * poses[1]
        if points.size > 1:
            gaps = np.abs(points[:, None] - points) + np.diag(np.full(points.size, np.inf))
            k = first_smallest(gaps.flat)
            if short_of(gaps.flat[k], self.smallest_gap[0]):
                self.smallest_gap = (float(gaps.flat[k]), t, divmod(k, points.size))
        x_min, x_max, y_min, y_max = arena.robot.boundaries
        wall = np.minimum.reduce([poses[0] - x_min, x_max - poses[0], poses[1] - y_min])
        wall = np.minimum(wall, y_max - poses[1])
        robot = first_smallest(wall)
        if short_of(wall[robot], self.wall_gap[0]):
            self.wall_gap = (float(wall[robot]), t, robot)

    def _hear(self, t: float, arena: Any) -> None:
        """Count how long the robots drive on without a new command."""
        if arena.is_commanded or not np.abs(arena.velocities).max(initial=0.0) > 0:
            self._silence = 0.0
        else:
            self._silence += arena.robot.time_step
            if beyond(self._silence, self.silent[0]):
                self.silent = (self._silence, t)

    def after_step(self, time_step: float) -> None:
        """Let the step's time pass; the simulator's own work is not the script's."""
        self.clock.advance(self._left)


def run_trial(plan: TrialPlan) -> None:
    """Run the trial in this process, which it uses up, and leave ``outcome.json`` in `results`."""
    results = Path(plan.results)
    pulse = open_pulse(results)
    said = os.open(results / "said.txt", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for descriptor in (1, 2):
        os.dup2(said, descriptor)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    sys.stdout = open(1, "w", buffering=1, errors="replace", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", buffering=1, errors="replace", closefd=False)  # noqa: SIM115
    violations = os.open(results / "violations.jsonl", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    outcome = Outcome(plan.name, seed=plan.seed, profile=plan.profile.get("name", "ideal"))
    try:
        _run(plan, outcome, pulse, violations)
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        text = json.dumps(asdict(outcome))
        Guard.active = None
        (results / "outcome.part").write_text(text)
        os.replace(results / "outcome.part", results / "outcome.json")
        os._exit(0)


def open_pulse(results: Path) -> mmap.mmap:
    """Open the few shared bytes in which a trial says how far it is."""
    with open(results / "pulse", "a+b") as file:
        file.truncate(mmap.PAGESIZE)
        return mmap.mmap(file.fileno(), mmap.PAGESIZE)


def read_pulse(pulse: mmap.mmap) -> tuple[int, float, float, float]:
    """Return steps done, seconds of the run, and wall clock and CPU time of the last step."""
    steps, t, wall, cpu = _PULSE.unpack(pulse[: _PULSE.size])
    return int(steps), float(t), float(wall), float(cpu)


def _run(plan: TrialPlan, outcome: Outcome, pulse: mmap.mmap, violations: int) -> None:
    import random

    import rps_compat
    from rps_compat.own_imports import keep_apart
    from rps_compat.profiles import profile_from_dict
    from rps_compat.realism import Imperfections
    from rps_compat.repeatable import repeatable
    from rps_compat.session import Session

    clock = SimulatedClock(charge=True)
    watch = Watch(plan, pulse, clock)
    profile = profile_from_dict(plan.profile) if plan.profile else None
    session = Session(
        initial=plan.initial,  # type: ignore[arg-type]
        seed=plan.seed,
        realism=None if profile is None else lambda: Imperfections(profile),
        recorder=lambda robots: watch,
        created=watch.created,
        pace=watch,
    )
    scratch = os.path.realpath(plan.scratch)
    os.chdir(scratch)
    sys.argv = [plan.script]
    sys.path[:0] = [scratch, *plan.path]
    sys.dont_write_bytecode = True
    random.seed(plan.seed)
    np.random.seed(plan.seed % 2**32)  # noqa: NPY002 - the script's stream, not ours
    rps_compat.install(generation=plan.generation)
    keep_apart(scratch)
    _limit(plan.memory)
    guard = Guard(scratch, violations, lambda: watch._steps)
    guard.install()
    builtins.input = guard.answer
    _listen(watch, plan.generation)
    with repeatable(plan.seed):
        _run_guarded(plan, outcome, session, clock, watch, scratch)
    _describe(outcome, watch, plan)


def _run_guarded(
    plan: TrialPlan,
    outcome: Outcome,
    session: Any,
    clock: SimulatedClock,
    watch: Watch,
    scratch: str,
) -> None:
    import atexit

    from rps_compat.bridges import dropped_names, one_element_conversions
    from rps_compat.scripts.changes import Kind

    # What the testbed's libraries have and newer ones dropped is there, as it is on the testbed.
    as_there = dropped_names(Kind.LATER), one_element_conversions()
    try:
        with session.active(), clock.in_force(), as_there[0], as_there[1]:
            try:
                runpy.run_path(os.path.join(scratch, plan.script), run_name="__main__")
            finally:
                atexit._run_exitfuncs()
        outcome.ended = "finished"
    except Enough:
        outcome.ended = "stopped"
    except KeyboardInterrupt as error:
        outcome.ended = "interrupted"
        outcome.error = _error(error, scratch)
    except SystemExit as error:
        failed = error.code not in (None, 0)
        outcome.ended = "exited" if failed else "finished"
        if failed:
            outcome.error = _error(error, scratch)
    except MemoryError as error:
        outcome.ended = "memory"
        outcome.error = _error(error, scratch)
    except Stuck as error:
        outcome.ended = "hung"
        outcome.error = _error(error, scratch)
    except BaseException as error:
        outcome.ended = "crashed"
        outcome.error = _error(error, scratch)
        traceback.print_exc()
    if watch.seen_enough:  # a `finally:` may fail on what the script had no time to make
        outcome.ended, outcome.error = "stopped", {}
    elif watch.over_time:
        outcome.ended = "over-time"
    elif plan.interrupt_at is not None and watch._interrupted and outcome.ended == "finished":
        outcome.ended = "interrupted"


def _listen(watch: Watch, generation: int) -> None:
    """Be told of the finishing call."""
    from importlib import import_module

    kind = import_module(f"rps_compat.v{generation}.robotarium").Robotarium
    if watch.plan.only_start:

        def enough(_: Any) -> None:
            watch.seen_enough = True
            raise Enough

        kind.get_poses = enough
    finish = "debug" if generation == 2 else "call_at_scripts_end"
    finishing = getattr(kind, finish)

    def finished(self: Any) -> None:
        watch.finished = True
        finishing(self)

    setattr(kind, finish, finished)


def _limit(memory: int) -> None:
    """Limit what the trial may allocate beyond what it has now, and what it may write."""
    with (
        open("/proc/self/statm") if os.path.exists("/proc/self/statm") else open(os.devnull) as file
    ):
        pages = file.read().split()
    used = int(pages[0]) * mmap.PAGESIZE if pages else 1 << 30
    for kind, amount in (
        (resource.RLIMIT_AS, used + memory),
        (resource.RLIMIT_FSIZE, 1 << 30),
        (resource.RLIMIT_CORE, 0),
    ):
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(kind, (amount, resource.getrlimit(kind)[1]))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)


def _error(error: BaseException, scratch: str) -> dict[str, Any]:
    frames = [
        (frame.lineno, os.path.basename(frame.filename))
        for frame in traceback.extract_tb(error.__traceback__)
        if frame.filename.startswith(scratch)
    ]
    line, file = frames[-1] if frames else (None, "")
    return {
        "type": type(error).__name__,
        "kinds": [kind.__name__ for kind in type(error).__mro__],
        "message": str(error).replace(scratch + os.sep, "")[:500],
        "missing": _missing_file(error, scratch),
        "module": error.name if isinstance(error, ModuleNotFoundError) else None,
        "line": line,
        "file": file,
        "lines": [frame for frame in frames if frame[0]],
    }


def _missing_file(error: BaseException, scratch: str) -> str:
    """Return the file beside the script that an error says is not there, or nothing."""
    name = error.filename if isinstance(error, FileNotFoundError) else None
    if not isinstance(name, (str, bytes, os.PathLike)):
        return ""
    path = os.path.join(scratch, os.fsdecode(name))
    return os.path.basename(path) if os.path.dirname(path) == scratch else ""


def _describe(outcome: Outcome, watch: Watch, plan: TrialPlan) -> None:
    """Fill in what was measured."""
    outcome.generation = plan.generation
    outcome.clock = watch.seconds
    outcome.steps = watch._steps
    outcome.finishing_call = watch.finished
    if watch.loops:
        loops = np.array(watch.loops)
        worst = int(loops.argmax())
        outcome.loop = {
            "p50": float(np.quantile(loops, 0.5)),
            "p99": float(np.quantile(loops, 0.99)),
            "max": float(loops.max()),
            "late": float(np.mean(loops > testbed.TIME_STEP)),
            "at": (worst + 1) * testbed.TIME_STEP,
        }
    outcome.silent = {"seconds": watch.silent[0], "at": watch.silent[1]}
    if not watch.arenas:
        return
    arena = watch.arenas[-1]
    found = arena.violations
    outcome.robots, outcome.time_step = arena.number_of_robots, arena.robot.time_step
    outcome.time = arena.time
    outcome.events = [
        [event.kind, list(event.robots), event.first, event.last, event.worst]
        for event in found.events[:200]
    ]
    outcome.close_pairs, outcome.outside_steps = found.close_pairs, found.outside_steps
    outcome.actuator_steps = found.actuator_steps
    outcome.largest_wheel = found.largest_wheel_velocity
    for name in ("smallest_gap", "initial_gap"):
        gap, t, pair = getattr(watch, name)
        if np.isfinite(gap):
            setattr(outcome, name, {"metres": gap, "time": t, "robots": list(pair)})
    gap, t, robot = watch.wall_gap
    if np.isfinite(gap):
        outcome.wall_gap = {"metres": gap, "time": t, "robots": [robot]}
