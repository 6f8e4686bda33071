"""Run a bundle as the testbed would: its Python, its libraries, its folder, and no network.

The environment is built once, with the testbed's versions, and cached.  In it the bundle runs as
``main.py`` from a scratch folder that holds the uploaded files and nothing else; ``rps`` is our
simulator, under a realism profile.  None of our packages can be imported but those that the
bundle carries: the simulator lives there under a private name.  After the declared duration a
KeyboardInterrupt ends the run inside ``step()``.  What the script wrote comes back, with
``log.txt``, and is opened once to see that it can be.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from posflock_robotarium.flocking.errors import OutputError, ParameterError
from posflock_robotarium.submission.environment import Environment, build_environment
from posflock_robotarium.submission.manifest import Manifest, check_manifest
from posflock_robotarium.submission.private_simulator import PRIVATE, lay_simulator
from posflock_robotarium.submission.returned_files import (
    FileState,
    ReturnedFile,
    bring_back,
    describe_file,
)
from rps_compat import testbed
from rps_compat.containment.caches import lay_font_list
from rps_compat.containment.keeper import ProcessEnd, ProcessOrder
from rps_compat.containment.kept import KeptFolder, KeptProcess
from rps_compat.containment.namespaces import (
    Containment,
    contained,
    containment_here,
    python_folders,
)
from rps_compat.containment.room import Room
from rps_compat.containment.usage import Allowance
from rps_compat.running.outcome import Ended, Outcome
from rps_compat.running.plan import RunPlan
from rps_compat.running.policy_violations import PolicyKind
from rps_compat.running.watching import Listener, new_word
from rps_compat.scripts import import_graph
from rps_compat.whole_files import remove_drafts

if TYPE_CHECKING:
    from rps_compat.realism import Profile

#: What the testbed calls the main file.
_MAIN = "main.py"
#: Names in the room of a rehearsal.
_SIMULATOR, _PRINTED = "private", "said.txt"
#: What a rehearsal may use; as on the testbed, libraries may be large.
_ALLOWANCE = Allowance(memory=4 << 30)
#: Seconds of real time after the time limit, after which a run that goes on is killed.
_GRACE = 10.0
#: Ends of a run that are none of its faults.
_GOOD = (Ended.FINISHED, Ended.IDLE, Ended.OVER_TIME)
#: How robots may come to their initial conditions.
_WAYS_TO_BEGIN = ("arrive", "exact", "drive")


@dataclass(frozen=True)
class Rehearsal:
    """What came of it.

    Attributes
    ----------
    outcome : Outcome
        How the run went.
    folder : Path
        What came back: the files that the script wrote, and ``log.txt``.
    files : dict of str to ReturnedFile
        Each of them by name, and what was found on opening it.
    environment : Environment
        Where it ran.
    containment : Containment
        What held it.
    """

    outcome: Outcome
    folder: Path
    files: dict[str, ReturnedFile]
    environment: Environment
    containment: Containment

    @property
    def passed(self) -> bool:
        """Whether the script ended by itself, or by the declared duration, and its files open."""
        outcome = self.outcome
        broken = outcome.error is not None and outcome.error.type != "KeyboardInterrupt"
        collided = outcome.report is not None and outcome.report.pairs_too_close > 0
        opened = all(found.state is not FileState.UNREADABLE for found in self.files.values())
        stayed = all(
            found.kind is not PolicyKind.OUTSIDE_WRITE for found in outcome.policy_violations
        )
        return outcome.ended in _GOOD and not broken and not collided and opened and stayed

    @property
    def reason(self) -> str:
        """Why it ended badly: the line of main.py and the error; empty where it did not."""
        outcome, error = self.outcome, self.outcome.error
        if error is None or error.type == "KeyboardInterrupt":
            return "" if outcome.ended in _GOOD else outcome.reason
        if outcome.left_with_code:
            code = error.message
            return f"exit code {code if code == str(outcome.exit_code) else repr(code)}"
        main = [place for place in error.lines if place[1] == _MAIN]
        others = [place for place in error.lines if place[1] != _MAIN]
        words = [f"{file}, line {line}" for line, file in main[-1:] + others[-1:]]
        place = words[0] + (f" ({words[1]})" if words[1:] else "") + ": " if words else ""
        what = f"{error.full_type}: {error.message}".rstrip(": ")
        return place + what.partition("\n")[0]

    def as_dict(self) -> dict[str, Any]:
        """Return plain data, ready for JSON."""
        environment = asdict(self.environment) | {"python": str(self.environment.python)}
        return {
            "passed": self.passed,
            "reason": self.reason,
            "outcome": self.outcome.as_dict(),
            "folder": str(self.folder),
            "files": {
                name: {"state": found.state.value, "about": found.about}
                for name, found in self.files.items()
            },
            "environment": environment,
            "containment": self.containment.value,
        }


def rehearse(
    folder: Path | str,
    out: Path | str,
    *,
    duration: float = testbed.MAX_DURATION,
    profile: Profile | str | Path | None = None,
    seed: int = 0,
    generation: int = 2,
    initial: str = "arrive",
    timeout: float = 600.0,
    environment: Environment | None = None,
    tell: Callable[[str], None] | None = None,
) -> Rehearsal:
    """Run the bundle in `folder` and put what comes back into `out`.

    Parameters
    ----------
    folder : path
        A bundle, as :func:`posflock_robotarium.submission.bundle.bundle` makes it.
    out : path
        A new or empty folder.
    duration : float
        Seconds that are declared; then the run is interrupted.
    profile : Profile, name or path
        Imperfections of motors and tracking; by default those of the generation's robots.
    seed : int
        Of everything random that is the testbed's.
    generation : int
        Of the API, 1 or 2.
    initial : str
        How robots come to their initial conditions: ``arrive`` within 5 cm and 0.2 rad,
        ``exact``, or ``drive``.
    timeout : float
        Seconds of real time after which the run is stopped, and soon killed.
    environment : Environment, optional
        Where to run it instead of in the testbed's copy.
    tell : callable, optional
        Is told what is being done.

    Raises
    ------
    BundleError
        Where `folder` is not an unchanged bundle.
    RehearsalError
        Where the environment cannot be built.
    OutputError
        Where `out` cannot be written or is not empty.
    ParameterError
        Where an option is outside its range.
    """
    _refuse_outside_ranges(duration, timeout, initial, generation)
    folder, out = Path(folder), Path(out)
    plan = replace(_plan(duration, profile, seed, generation, initial), timeout=timeout)
    manifest = check_manifest(folder)
    _empty(out)
    libraries = import_graph.trace(folder / manifest.main).libraries
    environment = environment or build_environment(libraries, tell)
    if tell is not None:
        tell(f"rehearsing {manifest.main} under Python {environment.version}")
    return _rehearsed(folder, out, manifest, plan, environment)


def _refuse_outside_ranges(duration: float, timeout: float, initial: str, generation: int) -> None:
    if not 0 < duration <= testbed.MAX_DURATION:
        raise ParameterError(
            f"duration: expected above 0 and at most {testbed.MAX_DURATION:.0f} s, got {duration}"
        )
    if not timeout > 0:
        raise ParameterError(f"timeout: expected more than 0 s, got {timeout}")
    if initial not in _WAYS_TO_BEGIN:
        raise ParameterError(f"initial: expected {', '.join(_WAYS_TO_BEGIN)}, got {initial!r}")
    if generation not in (1, 2):
        raise ParameterError(f"generation: expected 1 or 2, got {generation}")


def _plan(
    duration: float, profile: Profile | str | Path | None, seed: int, generation: int, initial: str
) -> RunPlan:
    """Return how the main file is run, its folder still to be made."""
    from rps_compat.profiles import chosen_profile, profile_to_dict

    chosen = chosen_profile(profile, generation)
    return RunPlan(
        script=_MAIN,
        folder="",
        generation=1 if generation == 1 else 2,
        initial=initial,  # type: ignore[arg-type]  # checked above
        seed=seed,
        profile=profile_to_dict(chosen) if chosen.effects else None,
        wait=False,
        keeps_apart=False,
        forbidden=(PolicyKind.OUTSIDE_WRITE, PolicyKind.NETWORK),
        forbidden_to_libraries=True,
        longest=duration,
        kills_deaf=True,
        memory=_ALLOWANCE.memory,
        disk=_ALLOWANCE.disk,
    )


def _rehearsed(
    folder: Path, out: Path, manifest: Manifest, plan: RunPlan, environment: Environment
) -> Rehearsal:
    """Run the bundle in a room of its own, and bring back what it wrote."""
    how = containment_here()
    with KeptFolder("rehearsal") as room:
        scratch = room / "upload"
        scratch.mkdir()
        for name in manifest.files:
            shutil.copyfile(folder / name, scratch / (_MAIN if name == manifest.main else name))
        lay_simulator(room / _SIMULATOR)
        fonts = room / "matplotlib"
        lay_font_list(environment.python, fonts)
        plan = replace(plan, folder=str(scratch), writable=(str(fonts),))
        end = _run(environment, plan, room, how)
        uploaded = set(manifest.files) - {manifest.main} | {_MAIN}
        back = bring_back(scratch, out, uploaded, end.said)
    files = {name: describe_file(out / name) for name in back if name != "log.txt"}
    return Rehearsal(_outcome(plan, end), out, files, environment, how)


@dataclass(frozen=True)
class _End:
    """How the process of a rehearsal ended, what it told, and what it printed."""

    process: ProcessEnd
    told: Listener
    said: str


def _run(environment: Environment, plan: RunPlan, room: Path, how: Containment) -> _End:
    """Run the plan in a process of its own, and end that with all that it started."""
    assert plan.timeout is not None
    launcher = Path(__file__).with_name("rehearsal_launcher.py")
    writable = (plan.folder, *plan.writable)
    readable = (str(room / _SIMULATOR), str(launcher.parent), *python_folders(environment.python))
    command = [str(environment.python), "-I", "-B", str(launcher)]
    printed = room / _PRINTED
    order = ProcessOrder(
        contained(how, Room(writable, readable, plan.folder), command),
        seconds=plan.timeout + _GRACE,
        folder=plan.folder,
        printed=str(printed),
        allowance=asdict(_ALLOWANCE),
    )
    kept = {name: os.environ[name] for name in ("PATH", "HOME", "LANG") if name in os.environ}
    ear, mouth = os.pipe()
    told = Listener(ear, new_word())
    # Into a file: a pipe would stay open as long as anything that the script left running.
    with open(printed, "ab") as said:
        process = KeptProcess(
            order,
            cwd=plan.folder,
            stdin=subprocess.PIPE,
            stdout=said,
            stderr=subprocess.STDOUT,
            pass_fds=(mouth,),
            env=kept
            | {
                "MPLBACKEND": "Agg",
                "MPLCONFIGDIR": plan.writable[0],
                "OPENBLAS_NUM_THREADS": "1",
                "PYTHONUNBUFFERED": "1",
            },
        )
    os.close(mouth)
    try:
        process.stdin.write(
            json.dumps(
                {
                    "simulator": str(room / _SIMULATOR),
                    "package": PRIVATE["rps_compat"],
                    "plan": asdict(plan),
                    "pipe": mouth,
                    "word": told.word,
                }
            )
        )
        process.stdin.close()
        end = process.wait(told.hear)
    finally:
        process.end()
        told.close()
    text = printed.read_text(encoding="utf-8", errors="replace")[: _ALLOWANCE.output]
    return _End(end, told, text)


def _outcome(plan: RunPlan, end: _End) -> Outcome:
    """Return what the run tells of itself, or what is known of it."""
    if end.told.said is not None:
        return end.told.said
    code, process = end.process.code, end.process
    ended, reason = Ended.HUNG, "it was killed, or went on after it had been interrupted"
    if process.surplus:
        ended, reason = Ended.DIED, f"it was killed: {process.surplus}"
    elif 0 <= code <= 128 and not process.timed_out:  # not by a signal
        ended, reason = Ended.DIED, f"its process ended itself, exit code {code}"
    script = Path(plan.folder, plan.script)
    violations = tuple(end.told.violations)
    return Outcome(
        script, plan.generation, ended, reason, abs(code) or 1, policy_violations=violations
    )


def _empty(out: Path) -> None:
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot write into {out}: {error}") from error
    remove_drafts(out)  # of a rehearsal that was killed
    if any(out.iterdir()):
        raise OutputError(f"{out} is not empty; choose a new folder for what comes back")


def report_on(done: Rehearsal) -> Path | None:
    """Open the pose logs that came back with the report, and return its page; None without any.

    Parameters
    ----------
    done : Rehearsal
        What came back.

    Raises
    ------
    PosflockError
        Where a log that looks like one cannot be analysed.
    """
    from posflock_robotarium.report import analyse
    from posflock_robotarium.report.outputs import write_report

    logs = [
        done.folder / name
        for name, found in done.files.items()
        if found.state is FileState.POSE_LOG
    ]
    if not logs:
        return None
    written = write_report([analyse(log) for log in logs], done.folder / "report", figures=False)
    return Path(written[0])
