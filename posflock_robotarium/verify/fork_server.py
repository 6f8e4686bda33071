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
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from posflock_robotarium.verify.trial import (
    Outcome,
    TrialPlan,
    open_pulse,
    read_pulse,
    run_trial,
)

#: Signals that end the fork server.
_ENDING = (signal.SIGINT, signal.SIGTERM)


@dataclass
class _Child:
    pid: int
    plan: TrialPlan
    pulse: mmap.mmap
    started: float
    asked: bool = False


def serve(request: dict[str, Any]) -> None:
    """Run all trials of `request`; see :mod:`posflock_robotarium.verify.trials` for its fields."""
    for name in request["preload"]:
        with contextlib.suppress(Exception):
            importlib.import_module(name)
    waiting = [TrialPlan(**plan) for plan in request["plans"]]
    children: list[_Child] = []
    try:
        while waiting or children:
            while waiting and len(children) < request["jobs"]:
                with _signals_held():  # no child may be born that nobody knows of
                    children.append(_fork(waiting.pop(0)))
            time.sleep(0.01)
            for child in list(children):
                why = _overdue(child, request["stall"], request["seconds"])
                pid, status = os.waitpid(child.pid, os.WNOHANG)
                if pid == 0 and why is None:
                    continue
                if pid == 0:
                    _kill(child)
                    _, status = os.waitpid(child.pid, 0)
                children.remove(child)
                left = _survivors(child)
                print(json.dumps(_outcome(child, status, why, left)), flush=True)
    finally:  # whoever ends this process ends the trials
        for child in children:
            _survivors(child)
    print(flush=True)


def _fork(plan: TrialPlan) -> _Child:
    results = Path(plan.results)
    pulse = open_pulse(results)
    pid = os.fork()
    if pid == 0:
        _die_with_parent()
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        os.setpgid(0, 0)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _ENDING)
        with open(results / "where.txt", "w") as where:
            faulthandler.register(signal.SIGUSR1, where, all_threads=False)
            run_trial(plan)
        os._exit(0)
    with contextlib.suppress(OSError):
        os.setpgid(pid, pid)
    return _Child(pid, plan, pulse, time.time())


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


def _overdue(child: _Child, stall: float, seconds: float) -> str | None:
    """Say why a child must be ended now, if so.

    What counts is computing time; a busy machine must not make a sound script hang. A child that
    waits uses none, so there is a wall clock limit, too, ten times as long.
    """
    now, used = time.time(), _cpu_seconds(child.pid)
    _, _, wall, cpu = read_pulse(child.pulse)
    if used - cpu > stall or now - max(wall, child.started) > 10 * stall:
        return "stall"
    return "seconds" if used > seconds or now - child.started > 10 * seconds else None


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


def _outcome(child: _Child, status: int, why: str | None, left: bool) -> dict[str, Any]:
    plan, results = child.plan, Path(child.plan.results)
    try:
        said: dict[str, Any] = json.loads((results / "outcome.json").read_text())
    except (OSError, ValueError):
        said = _obituary(child, status, why)
    if why is not None and said["ended"] in ("finished", "died"):
        said["ended"] = "hung"
    violations = results / "violations.jsonl"
    if violations.exists():
        said["policy_violations"] = [
            json.loads(line) for line in violations.read_text().splitlines()
        ]
        for violation in said["policy_violations"]:
            violation["time"] = violation.pop("step") * said["time_step"]
    if left:
        said["policy_violations"].append(
            {"kind": "fork", "what": "left processes running", "line": None, "file": "", "time": 0}
        )
    said["said"] = _tail(results / "said.txt")
    said["files"] = _files(Path(plan.scratch), plan.script)
    return said


def _obituary(child: _Child, status: int, why: str | None) -> dict[str, Any]:
    """Say what is known of a trial that could not speak for itself."""
    from dataclasses import asdict

    steps, t, _, _ = read_pulse(child.pulse)
    outcome = Outcome(child.plan.name, steps=steps, time=t, clock=t, seed=child.plan.seed)
    outcome.generation = child.plan.generation
    outcome.profile = child.plan.profile.get("name", "ideal")
    number = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
    if child.plan.kill_at is not None and number == signal.SIGKILL and why is None:
        outcome.ended = "killed"
    elif why is not None:
        outcome.ended = "hung"
        outcome.error = _where(child)
    else:
        name = signal.Signals(number).name if number else f"exit code {os.WEXITSTATUS(status)}"
        outcome.ended = "died"
        outcome.error = {"type": name, "message": f"the process ended by {name}"}
    return asdict(outcome)


def _where(child: _Child) -> dict[str, Any]:
    """Find the script's line in what faulthandler wrote when the child was asked."""
    out: dict[str, Any] = {"type": "", "message": "no step", "line": None, "file": ""}
    with contextlib.suppress(OSError):
        text = (Path(child.plan.results) / "where.txt").read_text(errors="replace")
        scratch = os.path.realpath(child.plan.scratch)
        for file, line in re.findall(r'File "(.+?)", line (\d+)', text):
            if file.startswith(scratch):
                out |= {"line": int(line), "file": os.path.basename(file)}
                out["lines"] = [[int(line), os.path.basename(file)]]
                break
    return out


def _tail(path: Path, size: int = 4000) -> str:
    try:
        with open(path, "rb") as file:
            file.seek(max(0, path.stat().st_size - size))
            return file.read().decode(errors="replace")
    except OSError:
        return ""


def _files(scratch: Path, script: str) -> dict[str, int]:
    """Return the sizes of the files in a scratch folder."""
    return {
        str(path.relative_to(scratch)): path.stat().st_size
        for path in sorted(scratch.rglob("*"))
        if path.is_file() and "__pycache__" not in path.parts
    }


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    for line in sys.stdin:
        serve(json.loads(line))
