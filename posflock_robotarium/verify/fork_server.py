"""The fork server: a process that forks one child a trial, watches it and ends it in time.

``python -m posflock_robotarium.verify.fork_server`` reads JSON requests on its standard input, one
a line. For each it imports what the trials need, forks them, so many at a time, and writes one JSON
line a finished trial, and an empty line at the end.  Being a process of its own, in a containment
of its own, whatever a script does to it does not reach the verifier.  A trial is killed, with
everything it started, when it has not stepped for too long, or has used up what it may use.
"""

from __future__ import annotations

import contextlib
import faulthandler
import importlib
import itertools
import json
import mmap
import os
import re
import signal
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO

from posflock_robotarium.verify.request import Request
from posflock_robotarium.verify.trial import run_trial
from rps_compat.containment import kernel
from rps_compat.containment.processes import descendants, end_descendants, look_at
from rps_compat.containment.usage import Allowance, FolderWatch, Resource, Surplus
from rps_compat.running.outcome import Ended, Failure, Outcome
from rps_compat.running.plan import RunPlan
from rps_compat.running.policy import ForbiddenError
from rps_compat.running.policy_violations import PolicyKind, PolicyViolation
from rps_compat.running.watching import Listener, Teller, new_word, read_pulse

#: Signals that end the fork server.
_ENDING = (signal.SIGINT, signal.SIGTERM)
#: File beside the script's folder for what it prints.
PRINTED = "printed.txt"
#: Files that are told of one trial.
_MOST_FILES = 1000
#: Seconds between two looks at what a trial uses.
_LOOK = 0.1
_TOO_MUCH = {
    Resource.PROCESSES: PolicyKind.FORK,
    Resource.MEMORY: PolicyKind.MEMORY,
    Resource.DISK: PolicyKind.DISK,
}


@dataclass
class _Child:
    pid: int
    plan: RunPlan
    listener: Listener
    pulse: mmap.mmap
    where: IO[str]
    watch: FolderWatch
    started: float = field(default_factory=time.time)
    looked: float = 0.0
    surplus: Surplus | None = None

    def look(self, allowance: Allowance) -> None:
        """Hear what the trial tells, and see now and then whether it uses too much."""
        self.listener.hear()
        if time.monotonic() - self.looked < _LOOK:
            return
        self.looked = time.monotonic()
        running = [process for process in descendants(self.pid) if not process.ended]
        own = look_at(self.pid)
        self.surplus = allowance.surplus([*running, *([own] if own else [])])
        self.surplus = self.surplus or self.watch.surplus()


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
                    children.append(_fork(waiting.pop(0), request.allowance, children))
            time.sleep(0.01)
            for child in list(children):
                outcome = _outcome_if_over(child, children, request)
                if outcome is not None:
                    print(json.dumps(outcome.as_dict()), flush=True)
    finally:  # whoever ends this process ends the trials
        for child in children:
            _end_group(child)
        end_descendants()
    print(flush=True)


def _fork(plan: RunPlan, allowance: Allowance, others: Sequence[_Child]) -> _Child:
    beside = Path(plan.folder).parent
    printed = beside / PRINTED
    ear, mouth = os.pipe()
    word = new_word()
    pulse = mmap.mmap(-1, mmap.PAGESIZE)
    where = tempfile.TemporaryFile("w+", dir=beside)  # noqa: SIM115 - closed with the child
    pid = os.fork()
    if pid == 0:
        for descriptor in (ear, *(other.listener.pipe for other in others)):
            os.close(descriptor)
        for change in (kernel.die_with_parent, lambda: kernel.keep_private(False)):
            with contextlib.suppress(OSError):
                change()
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        os.setpgid(0, 0)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _ENDING)
        faulthandler.register(signal.SIGUSR1, where, all_threads=False)
        run_trial(plan, Teller(mouth, word, pulse), printed)
        os._exit(0)
    os.close(mouth)
    with contextlib.suppress(OSError):
        os.setpgid(pid, pid)
    watch = FolderWatch(Path(plan.folder), printed, allowance)
    return _Child(pid, plan, Listener(ear, word), pulse, where, watch)


@contextlib.contextmanager
def _signals_held() -> Iterator[None]:
    """Let signals that end this process wait until the block is done."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _ENDING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _outcome_if_over(child: _Child, children: list[_Child], request: Request) -> Outcome | None:
    """Return the outcome of a trial that has ended or must end now; None where it goes on."""
    child.look(request.allowance)
    overdue = _overdue(child, request.stall, request.seconds)
    pid, status = os.waitpid(child.pid, os.WNOHANG)
    if pid == 0 and not overdue and child.surplus is None:
        return None
    if pid == 0:
        if child.surplus is None:
            _ask_where_it_is(child)
        _end_group(child)
        _, status = os.waitpid(child.pid, 0)
    children.remove(child)
    left = _end_group(child)
    # Whatever has moved to another session is this process's child now, or the first process's.
    left = end_descendants([other.pid for other in children]) or left
    child.listener.close()
    outcome = _outcome(child, status, overdue, left)
    child.where.close()
    return outcome


def _overdue(child: _Child, stall: float, seconds: float) -> bool:
    """Whether a child must be ended now: it does not step any more, or its time is over.

    What counts is computing time; a busy machine must not make a sound script hang. A child that
    waits uses none, so there is a wall clock limit, too, ten times as long.
    """
    process = look_at(child.pid)
    now, used = time.time(), 0.0 if process is None else process.seconds
    _, _, wall, cpu = read_pulse(child.pulse)
    if used - cpu > stall or now - max(wall, child.started) > 10 * stall:
        return True
    return used > seconds or now - child.started > 10 * seconds


def _ask_where_it_is(child: _Child) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.kill(child.pid, signal.SIGUSR1)
        time.sleep(0.1)


def _end_group(child: _Child) -> bool:
    """End the process group of a trial; say whether there was anybody in it."""
    try:
        os.killpg(child.pid, signal.SIGKILL)
    except (ProcessLookupError, PermissionError):
        return False
    return True


def _outcome(child: _Child, status: int, overdue: bool, left: bool) -> Outcome:
    """Return what the trial tells, or what is known of it, and what it left."""
    outcome = child.listener.said or _obituary(child, status, overdue)
    if overdue and outcome.ended in (Ended.FINISHED, Ended.DIED):
        outcome = replace(outcome, ended=Ended.HUNG)
    violations = list(child.listener.violations)
    if child.surplus is not None:
        kind = _TOO_MUCH[child.surplus.resource]
        violations.append(PolicyViolation(kind, child.surplus.words))
    elif left:
        violations.append(PolicyViolation(PolicyKind.FORK, "left processes running"))
    folder = Path(child.plan.folder)
    return replace(outcome, policy_violations=tuple(violations), files=_files(folder))


def _obituary(child: _Child, status: int, overdue: bool) -> Outcome:
    """Say what is known of a trial that could not speak for itself."""
    plan = child.plan
    steps, t, _, _ = read_pulse(child.pulse)
    number = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
    ended, error = Ended.DIED, None
    if child.surplus is not None:
        kinds = (ForbiddenError.__name__,)  # the violation is told of
        error = Failure(kinds[0], kinds=kinds, message=child.surplus.words)
    elif plan.kill_at is not None and number == signal.SIGKILL and not overdue:
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
    child.where.seek(0)
    for file, line in re.findall(r'File "(.+?)", line (\d+)', child.where.read()):
        if file.startswith(child.plan.folder):
            place = int(line), os.path.basename(file)
            return Failure("", message="no step", line=place[0], file=place[1], lines=(place,))
    return Failure("", message="no step")


def _files(folder: Path) -> tuple[Path, ...]:
    """Return the files in the folder of a trial, relative to it; no links, and not endlessly."""
    found = (
        path.relative_to(folder)
        for path in folder.rglob("*")
        if path.is_file() and not path.is_symlink() and "__pycache__" not in path.parts
    )
    return tuple(sorted(itertools.islice(found, _MOST_FILES)))


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    for change in (kernel.adopt_orphans, lambda: kernel.keep_private(True)):
        with contextlib.suppress(OSError):
            change()
    for line in sys.stdin:
        serve(Request.of(line))
