"""One trial: a script run once in a process of its own, watched, limited and recorded.

The process was forked for this trial and ends with it.  The script sees the testbed's world: it
is ``__main__``, has no arguments, finds its files flat in the working folder, and ``rps`` is the
simulator under the trial's imperfections.  Two things are not as on the testbed, so that a trial
takes seconds: nothing is drawn, and nobody waits.  :class:`Clock` stands in for the time of day
and advances as the testbed's would, by the longer of 33 ms and what the script computed (CPU time
of this machine) or slept.

What a script must not do is stopped where it happens, by an audit hook, and reported with the
line: writing outside the scratch folder, starting processes, using the network.  That is a net
for mistakes, not a sandbox: native code passes it.
"""

from __future__ import annotations

import builtins
import contextlib
import json
import mmap
import os
import resource
import runpy
import signal
import struct
import sys
import time
import traceback
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium import testbed

#: Real functions, before a clock replaces them.
_cpu, _wall = time.process_time, time.time
_PULSE = struct.Struct("qddd")
_WRITE_FLAGS = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_TRUNC
_PATH_EVENTS = frozenset(
    [
        "os.remove",
        "os.rename",
        "os.mkdir",
        "os.rmdir",
        "os.link",
        "os.symlink",
        "os.chmod",
        "os.truncate",
        "os.chown",
        "shutil.rmtree",
    ]
)
_PROCESS_EVENTS = frozenset(
    [
        "subprocess.Popen",
        "os.system",
        "os.fork",
        "os.forkpty",
        "os.posix_spawn",
        "os.exec",
        "os.spawn",
        "pty.spawn",
    ]
)
_NETWORK_EVENTS = frozenset(
    ["socket.connect", "socket.getaddrinfo", "socket.sendto", "socket.bind"]
)


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
    deeds : list of dict
        Forbidden things: ``kind`` (a finding's code), ``what``, ``line``, ``time``.
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
    deeds: list[dict[str, Any]] = field(default_factory=list)
    files: dict[str, int] = field(default_factory=dict)
    finishing_call: bool = False
    said: str = ""
    seed: int = 0
    profile: str = ""


class ForbiddenError(PermissionError):
    """The script tried what it must not do; the deed is on record."""


class Enough(BaseException):
    """The trial has seen what it was for."""


class Clock:
    """The testbed's time of day for a script that does not wait.

    Between two steps pass the longer of 33 ms and what the script spent.
    """

    def __init__(self) -> None:
        self.start = _wall()
        self.now = 0.0
        self._slept = 0.0
        self._cpu = _cpu()

    def spent(self) -> float:
        """Seconds that the script computed and slept since the last step."""
        return _cpu() - self._cpu + self._slept

    def read(self) -> float:
        """Seconds since the start."""
        return self.now + self.spent()

    def sleep(self, seconds: float) -> None:
        """Let time pass, without waiting."""
        if seconds < 0:
            raise ValueError("sleep length must be non-negative")
        self._slept += seconds

    def step(self, time_step: float) -> None:
        """End a time step."""
        self.now += max(time_step, self.spent())
        self.resume()

    def resume(self) -> None:
        """Start counting the script's own time again."""
        self._cpu, self._slept = _cpu(), 0.0

    @contextlib.contextmanager
    def installed(self) -> Iterator[None]:
        """Let the module `time` tell this clock's time."""
        before = {name: getattr(time, name) for name in ("time", "monotonic", "perf_counter")}
        sleep = time.sleep
        time.time = lambda: self.start + self.read()
        time.monotonic = time.perf_counter = self.read
        time.sleep = self.sleep  # type: ignore[assignment]
        try:
            yield
        finally:
            for name, function in before.items():
                setattr(time, name, function)
            time.sleep = sleep


class Watch:
    """Sees every step: times it, measures the gaps, and ends the run where the plan says so."""

    def __init__(self, plan: TrialPlan, pulse: mmap.mmap, clock: Clock) -> None:
        self.plan = plan
        self.clock = clock
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
        if self._steps:
            self.loops.append(self.clock.spent())
        self.clock.step(arena.robot.time_step)
        self._measure(t, arena)
        self._hear(t, arena)
        self._steps += 1
        self._pulse[: _PULSE.size] = _PULSE.pack(self._steps, t, _wall(), _cpu())
        if plan.kill_at is not None and t >= plan.kill_at:
            os.kill(os.getpid(), signal.SIGKILL)
        if plan.interrupt_at is not None and t >= plan.interrupt_at and not self._interrupted:
            self._interrupted = True
            raise KeyboardInterrupt
        if max(self.clock.now, t) >= plan.longest:
            self.over_time = True
            self._refusals += 1
            raise KeyboardInterrupt if self._refusals < 10 else Enough

    def _measure(self, t: float, arena: Any) -> None:
        poses = arena.poses
        points = poses[0] + 1j * poses[1]
        if points.size > 1:
            gaps = np.abs(points[:, None] - points) + np.diag(np.full(points.size, np.inf))
            k = int(gaps.argmin())
            if gaps.flat[k] < self.smallest_gap[0]:
                self.smallest_gap = (float(gaps.flat[k]), t, divmod(k, points.size))
        x_min, x_max, y_min, y_max = arena.robot.boundaries
        wall = np.minimum.reduce([poses[0] - x_min, x_max - poses[0], poses[1] - y_min])
        wall = np.minimum(wall, y_max - poses[1])
        robot = int(wall.argmin())
        if wall[robot] < self.wall_gap[0]:
            self.wall_gap = (float(wall[robot]), t, robot)

    def _hear(self, t: float, arena: Any) -> None:
        """Count how long the robots drive on without a new command."""
        if arena.is_commanded or not np.abs(arena.velocities).max(initial=0.0) > 0:
            self._silence = 0.0
        else:
            self._silence += arena.robot.time_step
            if self._silence > self.silent[0]:
                self.silent = (self._silence, t)

    def after_step(self) -> None:
        """Let the script's time begin: the simulator's own work is not the script's."""
        self.clock.resume()


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
    deeds = os.open(results / "deeds.jsonl", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    outcome = Outcome(plan.name, seed=plan.seed, profile=plan.profile.get("name", "ideal"))
    try:
        _run(plan, outcome, pulse, deeds)
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        text = json.dumps(asdict(outcome))
        _Guard.active = None
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


def _run(plan: TrialPlan, outcome: Outcome, pulse: mmap.mmap, deeds: int) -> None:
    import random

    import rps_compat
    from rps_compat.profiles import profile_from_dict
    from rps_compat.realism import Imperfections
    from rps_compat.session import Session

    clock = Clock()
    watch = Watch(plan, pulse, clock)
    profile = profile_from_dict(plan.profile) if plan.profile else None
    session = Session(
        initial=plan.initial,  # type: ignore[arg-type]
        seed=plan.seed,
        realism=None if profile is None else lambda: Imperfections(profile),
        recorder=lambda robots: watch,
        created=watch.created,
        wait=False,
    )
    scratch = os.path.realpath(plan.scratch)
    os.chdir(scratch)
    sys.argv = [plan.script]
    sys.path[:0] = [scratch, *plan.path]
    sys.dont_write_bytecode = True
    random.seed(plan.seed)
    np.random.seed(plan.seed % 2**32)  # noqa: NPY002 - the script's stream, not ours
    rps_compat.install(api=plan.generation)
    _limit(plan.memory)
    guard = _Guard(scratch, deeds, watch)
    guard.install()
    builtins.input = guard.answer
    _listen(watch, plan.generation)
    _run_guarded(plan, outcome, session, clock, watch, scratch)
    _describe(outcome, watch, plan)


def _run_guarded(
    plan: TrialPlan, outcome: Outcome, session: Any, clock: Clock, watch: Watch, scratch: str
) -> None:
    import atexit

    try:
        with session.active(), clock.installed():
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
    """Be told of the end of each step and of the finishing call."""
    from importlib import import_module

    kind = import_module(f"rps_compat.v{generation}.robotarium").Robotarium
    if watch.plan.only_start:

        def enough(_: Any) -> None:
            watch.seen_enough = True
            raise Enough

        kind.get_poses = enough
    step, finish = kind.step, "debug" if generation == 2 else "call_at_scripts_end"
    finishing = getattr(kind, finish)

    def timed(self: Any) -> None:
        step(self)
        watch.after_step()

    def finished(self: Any) -> None:
        watch.finished = True
        finishing(self)

    kind.step = timed
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


class _Guard:
    """The audit hook; hooks cannot be removed, so it asks whether it is still on duty."""

    active: _Guard | None = None

    def __init__(self, scratch: str, deeds: int, watch: Watch) -> None:
        self.scratch = scratch
        self.deeds = deeds
        self.watch = watch

    def install(self) -> None:
        _Guard.active = self
        sys.addaudithook(_audit)

    def allows(self, path: Any) -> bool:
        if isinstance(path, int) or path is None:
            return True
        where = os.path.realpath(os.fsdecode(path))
        return where == self.scratch or where.startswith(
            (self.scratch + os.sep, "/dev/", "/proc/self/")
        )

    def record(self, kind: str, what: str) -> None:
        line, file = self.blame()
        steps = self.watch._steps
        deed = {"kind": kind, "what": what, "line": line, "file": file, "step": steps}
        os.write(self.deeds, (json.dumps(deed) + "\n").encode())

    def answer(self, prompt: object = "") -> str:
        """Stand in for ``input()``: nobody is there, which goes on record."""
        self.record("blocking-call", "input()")
        return ""

    def blame(self) -> tuple[int | None, str]:
        """Return the innermost line of the script's own files that is being run."""
        frame: FrameType | None = sys._getframe(2)
        while frame is not None:
            name = frame.f_code.co_filename
            if name.startswith(self.scratch):
                return frame.f_lineno, os.path.basename(name)
            frame = frame.f_back
        return None, ""

    def is_the_scripts(self) -> bool:
        """Whether the script asks, not a library that has its own reasons."""
        frame: FrameType | None = sys._getframe(2)
        while frame is not None:
            name = frame.f_code.co_filename
            if name.startswith(self.scratch):
                return True
            if "site-packages" in name or "dist-packages" in name:
                return False
            frame = frame.f_back
        return False


def _audit(event: str, arguments: tuple[Any, ...]) -> None:
    guard = _Guard.active
    if guard is None:
        return
    if event == "open":
        path, mode, flags = arguments[0], arguments[1], arguments[2]
        if isinstance(mode, str):
            writes = any(letter in mode for letter in "wax+")
        else:
            writes = isinstance(flags, int) and bool(flags & _WRITE_FLAGS)
        if writes and not guard.allows(path):
            _refuse(guard, "outside-write", os.fsdecode(path))
    elif event in _PATH_EVENTS:
        for path in arguments[:2]:
            if isinstance(path, (str, bytes, os.PathLike)) and not guard.allows(path):
                _refuse(guard, "outside-write", os.fsdecode(path))
    elif event in _PROCESS_EVENTS and guard.is_the_scripts():
        _refuse(guard, "fork", " ".join(str(a) for a in arguments[:2]) or event)
    elif event in _NETWORK_EVENTS and guard.is_the_scripts():
        _refuse(guard, "network", _address(event, arguments))
    elif event == "os.kill" and arguments[0] != os.getpid():
        _refuse(guard, "fork", f"kill {arguments[0]}")


def _address(event: str, arguments: tuple[Any, ...]) -> str:
    """Return whom a network event is about; sockets come first where there are any."""
    about = arguments[:2] if event == "socket.getaddrinfo" else arguments[1:]
    return " ".join(str(part) for part in about) or event


def _refuse(guard: _Guard, kind: str, what: str) -> None:
    _Guard.active = None  # recording opens nothing, but formatting might
    try:
        guard.record(kind, what)
    finally:
        _Guard.active = guard
    raise ForbiddenError(f"{kind}: {what}")


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
    outcome.clock = watch.clock.now
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
