"""The fork server: a process that forks one child a trial, watches it and ends it in time.

``python -m posflock_robotarium.verify.fork_server`` reads JSON requests on its standard input, one
a line. For each it imports what the trials need, forks them, so many at a time, and writes one JSON
line a finished trial, and an empty line at the end.  Being a process of its own, whatever a
script does to it does not reach the verifier.  A trial is killed, with everything it started in
its process group, when it has not stepped for too long, or has used up its time.
"""

from __future__ import annotations

import contextlib
import ctypes
import faulthandler
import importlib
import json
import mmap
import os
import re
import signal
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from posflock_robotarium.verify.request import Request
from posflock_robotarium.verify.trial import OUTCOME, run_trial
from rps_compat.running.driver import VIOLATIONS
from rps_compat.running.outcome import Ended, Failure, Outcome
from rps_compat.running.plan import RunPlan
from rps_compat.running.policy_violations import PolicyKind, PolicyViolation, read_violation
from rps_compat.running.schedule import open_pulse, read_pulse

#: Signals that end the fork server.
_ENDING = (signal.SIGINT, signal.SIGTERM)


@dataclass
class _Child:
    pid: int
    plan: RunPlan
    watched: Path
    pulse: mmap.mmap
    started: float
    asked: bool = False


def serve(request: Request) -> None:
    """Run all trials of a request.

    Parameters
    ----------
    request : Request
        The trials, what to import before them, how many run at a time, and what each may use.
    """
    for name in request.preload:
        with contextlib.suppress(Exception):
            importlib.import_module(name)
    waiting = list(request.plans)
    children: list[_Child] = []
    try:
        while waiting or children:
            while waiting and len(children) < request.jobs:
                with _signals_held():  # no child may be born that nobody knows of
                    children.append(_fork(waiting.pop(0)))
            time.sleep(0.01)
            for child in list(children):
                overdue = _overdue(child, request.stall, request.seconds)
                pid, status = os.waitpid(child.pid, os.WNOHANG)
                if pid == 0 and not overdue:
                    continue
                if pid == 0:
                    _kill(child)
                    _, status = os.waitpid(child.pid, 0)
                children.remove(child)
                left = _survivors(child)
                print(json.dumps(_outcome(child, status, overdue, left).as_dict()), flush=True)
    finally:  # whoever ends this process ends the trials
        for child in children:
            _survivors(child)
    print(flush=True)


def _fork(plan: RunPlan) -> _Child:
    assert plan.watched is not None
    watched = Path(plan.watched)
    pulse = open_pulse(watched)
    pid = os.fork()
    if pid == 0:
        _die_with_parent()
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        os.setpgid(0, 0)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _ENDING)
        with open(watched / "where.txt", "w") as where:
            faulthandler.register(signal.SIGUSR1, where, all_threads=False)
            run_trial(plan)
        os._exit(0)
    with contextlib.suppress(OSError):
        os.setpgid(pid, pid)
    return _Child(pid, plan, watched, pulse, time.time())


@contextlib.contextmanager
def _signals_held() -> Iterator[None]:
    """Let signals that end this process wait until the block is done."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _ENDING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _die_with_parent() -> None:
    """Have the kernel end this process with its parent, even one that is killed (Linux only)."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


def _overdue(child: _Child, stall: float, seconds: float) -> bool:
    """Whether a child must be ended now: it does not step any more, or its time is over.

    What counts is computing time; a busy machine must not make a sound script hang. A child that
    waits uses none, so there is a wall clock limit, too, ten times as long.
    """
    now, used = time.time(), _cpu_seconds(child.pid)
    _, _, wall, cpu = read_pulse(child.pulse)
    if used - cpu > stall or now - max(wall, child.started) > 10 * stall:
        return True
    return used > seconds or now - child.started > 10 * seconds


def _cpu_seconds(pid: int) -> float:
    """Return the computing time of a process; 0 where the system does not tell."""
    try:
        with open(f"/proc/{pid}/stat") as file:
            fields = file.read().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _kill(child: _Child) -> None:
    """Ask the child where it is, then end it and its process group."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(child.pid, signal.SIGUSR1)
        time.sleep(0.1)
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(child.pid, signal.SIGKILL)


def _survivors(child: _Child) -> bool:
    """End what the trial left running in its process group; say whether there was any."""
    try:
        os.killpg(child.pid, signal.SIGKILL)
    except (ProcessLookupError, PermissionError):
        return False
    return True


def _outcome(child: _Child, status: int, overdue: bool, left: bool) -> Outcome:
    """Return what the trial tells, or what is known of it, and what it left."""
    try:
        said = json.loads((child.watched / OUTCOME).read_text())
        outcome = Outcome.from_dict(said)
    except (OSError, ValueError):
        outcome = _obituary(child, status, overdue)
    if overdue and outcome.ended in (Ended.FINISHED, Ended.DIED):
        outcome = replace(outcome, ended=Ended.HUNG)
    violations = _violations(child.watched / VIOLATIONS)
    if left:
        violations.append(PolicyViolation(PolicyKind.FORK, "left processes running"))
    folder = Path(child.plan.folder)
    return replace(outcome, policy_violations=tuple(violations), files=_files(folder))


def _violations(record: Path) -> list[PolicyViolation]:
    """Read what a trial put on record at once: it may have been killed since."""
    if not record.exists():
        return []
    return [read_violation(json.loads(line)) for line in record.read_text().splitlines()]


def _obituary(child: _Child, status: int, overdue: bool) -> Outcome:
    """Say what is known of a trial that could not speak for itself."""
    plan = child.plan
    steps, t, _, _ = read_pulse(child.pulse)
    number = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
    ended, error = Ended.DIED, None
    if plan.kill_at is not None and number == signal.SIGKILL and not overdue:
        ended = Ended.KILLED
    elif overdue:
        ended, error = Ended.HUNG, _where(child)
    else:
        name = signal.Signals(number).name if number else f"exit code {os.WEXITSTATUS(status)}"
        error = Failure(type=name, message=f"the process ended by {name}")
    return Outcome(
        Path(plan.folder, plan.script),
        plan.generation,
        ended,
        reason="" if error is None else str(error),
        exit_code=128 + number if number else os.WEXITSTATUS(status),
        error=error,
        name=plan.name,
        seed=plan.seed,
        profile=plan.profile_name,
        steps=steps,
        time=t,
        clock=t,
    )


def _where(child: _Child) -> Failure:
    """Find the script's line in what faulthandler wrote when the child was asked."""
    text = ""
    with contextlib.suppress(OSError):
        text = (child.watched / "where.txt").read_text(errors="replace")
    for file, line in re.findall(r'File "(.+?)", line (\d+)', text):
        if file.startswith(child.plan.folder):
            place = int(line), os.path.basename(file)
            return Failure("", message="no step", line=place[0], file=place[1], lines=(place,))
    return Failure("", message="no step")


def _files(folder: Path) -> tuple[Path, ...]:
    """Return the files in the folder of a trial, relative to it."""
    return tuple(
        path.relative_to(folder)
        for path in sorted(folder.rglob("*"))
        if path.is_file() and "__pycache__" not in path.parts
    )


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    for line in sys.stdin:
        serve(Request.of(line))
