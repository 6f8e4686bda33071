"""Run a bundle as the testbed would: its Python, its libraries, its folder, and no network.

The environment is built once, with the testbed's versions, and cached.  In it the bundle runs as
``main.py`` from a scratch folder that holds the uploaded files and nothing else; ``rps`` is our
simulator, under a realism profile.  None of our packages can be imported but those that the
bundle carries: the simulator lives there under a private name.  After the declared duration a
KeyboardInterrupt ends the run inside ``step()``.  What the script wrote comes back, with
``log.txt``, and is opened once to see that it can be.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from posflock_robotarium.flocking.errors import OutputError, ParameterError
from posflock_robotarium.submission.environment import (
    Environment,
    build_environment,
    cache_folder,
)
from posflock_robotarium.submission.manifest import Manifest, check_manifest
from posflock_robotarium.submission.private_simulator import PRIVATE, lay_simulator
from posflock_robotarium.submission.returned_files import (
    FileState,
    ReturnedFile,
    bring_back,
    describe_file,
)
from rps_compat import testbed
from rps_compat.running.outcome import Ended, Outcome
from rps_compat.running.plan import RunPlan
from rps_compat.running.policy_violations import PolicyKind
from rps_compat.scripts import import_graph
from rps_compat.whole_files import remove_drafts

if TYPE_CHECKING:
    from rps_compat.realism import Profile

#: What the testbed calls the main file.
_MAIN = "main.py"
#: Names in the room of a rehearsal.
_SIMULATOR, _OUTCOME = "private", "outcome.json"
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
    network : str
        How the network was kept away.
    """

    outcome: Outcome
    folder: Path
    files: dict[str, ReturnedFile]
    environment: Environment
    network: str

    @property
    def passed(self) -> bool:
        """Whether the script ended by itself, or by the declared duration, and its files open."""
        outcome = self.outcome
        broken = outcome.error is not None and outcome.error.type != "KeyboardInterrupt"
        collided = outcome.report is not None and outcome.report.pairs_too_close > 0
        opened = all(found.state is not FileState.UNREADABLE for found in self.files.values())
        return outcome.ended in _GOOD and not broken and not collided and opened

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
            "network": self.network,
        }


def rehearse(
    folder: Path | str,
    out: Path | str,
    *,
    duration: float = testbed.MAX_DURATION,
    profile: Profile | str | Path = "gritsbot_x",
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
        Imperfections of motors and tracking.
    seed : int
        Of everything random that is the testbed's.
    generation : int
        Of the API, 1 or 2.
    initial : str
        How robots come to their initial conditions: ``arrive`` within 5 cm and 0.2 rad,
        ``exact``, or ``drive``.
    timeout : float
        Seconds of real time after which the run is interrupted, and soon killed.
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
    plan = _plan(duration, profile, seed, generation, initial)
    manifest = check_manifest(folder)
    _empty(out)
    libraries = import_graph.trace(folder / manifest.main).libraries
    environment = environment or build_environment(libraries, tell)
    if tell is not None:
        tell(f"rehearsing {manifest.main} under Python {environment.version}")
    return _rehearsed(folder, out, manifest, plan, environment, timeout)


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
    duration: float, profile: Profile | str | Path, seed: int, generation: int, initial: str
) -> RunPlan:
    """Return how the main file is run, its folder still to be made."""
    from rps_compat.profiles import load_profile, profile_to_dict
    from rps_compat.realism import Profile

    chosen = profile if isinstance(profile, Profile) else load_profile(profile)
    return RunPlan(
        script=_MAIN,
        folder="",
        generation=1 if generation == 1 else 2,
        initial=initial,  # type: ignore[arg-type]  # checked above
        seed=seed,
        profile=profile_to_dict(chosen) if chosen.effects else None,
        wait=False,
        keeps_apart=False,
        forbidden=(PolicyKind.NETWORK,),
        forbidden_to_libraries=True,
        longest=duration,
        kills_deaf=True,
    )


def _rehearsed(
    folder: Path,
    out: Path,
    manifest: Manifest,
    plan: RunPlan,
    environment: Environment,
    timeout: float,
) -> Rehearsal:
    """Run the bundle in a room of its own, and bring back what it wrote."""
    with tempfile.TemporaryDirectory(prefix="posflock-rehearsal-") as place:
        room = Path(place)
        scratch = room / "upload"
        scratch.mkdir()
        for name in manifest.files:
            shutil.copyfile(folder / name, scratch / (_MAIN if name == manifest.main else name))
        lay_simulator(room / _SIMULATOR)
        plan = replace(plan, folder=os.path.realpath(scratch))
        end = _run(environment, plan, room, timeout)
        uploaded = set(manifest.files) - {manifest.main} | {_MAIN}
        back = bring_back(scratch, out, uploaded, end.said)
        outcome = _read_outcome(room / _OUTCOME, plan, end)
    files = {name: describe_file(out / name) for name in back if name != "log.txt"}
    return Rehearsal(outcome, out, files, environment, end.network)


@dataclass(frozen=True)
class _End:
    """How the process of a rehearsal ended.

    Attributes
    ----------
    code : int
        Its exit code; below 0 where a signal ended it.
    timed_out : bool
        Whether its time was over.
    said : str
        What it printed.
    network : str
        How the network was kept away, in words.
    """

    code: int
    timed_out: bool
    said: str
    network: str


def _run(environment: Environment, plan: RunPlan, room: Path, timeout: float) -> _End:
    """Run the plan in a process of its own, and end that with all that it started."""
    launcher = Path(__file__).with_name("rehearsal_launcher.py")
    order = {
        "simulator": str(room / _SIMULATOR),
        "package": PRIVATE["rps_compat"],
        "plan": asdict(plan),
        "outcome": str(room / _OUTCOME),
    }
    (room / "order.json").write_text(json.dumps(order))
    command = [str(environment.python), "-I", "-B", str(launcher), str(room / "order.json")]
    network = "socket calls refused in Python; native code is not stopped"
    if _can_unshare():
        command = ["unshare", "--map-root-user", "--net", *command]
        network = "no network: a network namespace of its own"
    kept = {name: os.environ[name] for name in ("PATH", "HOME", "LANG") if name in os.environ}
    # Into a file: a pipe would stay open as long as anything that the script left running.
    with open(room / "said.txt", "wb") as said:
        process = subprocess.Popen(
            command,
            cwd=plan.folder,
            stdin=subprocess.DEVNULL,
            stdout=said,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            env=kept
            | {
                "MPLBACKEND": "Agg",
                "MPLCONFIGDIR": str(cache_folder() / "matplotlib"),
                "OPENBLAS_NUM_THREADS": "1",
                "PYTHONUNBUFFERED": "1",
            },
        )
        timed_out = False
        try:
            for grace, sent in ((timeout, signal.SIGINT), (10.0, signal.SIGKILL), (None, None)):
                try:
                    process.wait(timeout=grace)
                    break
                except subprocess.TimeoutExpired:
                    assert sent is not None
                    timed_out = True
                    os.killpg(process.pid, sent)
        finally:  # the run and whatever it started
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(process.pid, signal.SIGKILL)
    text = (room / "said.txt").read_text(encoding="utf-8", errors="replace")
    return _End(process.returncode, timed_out, text, network)


def _can_unshare() -> bool:
    if sys.platform != "linux" or shutil.which("unshare") is None:
        return False
    command = ["unshare", "--map-root-user", "--net", "true"]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def _read_outcome(path: Path, plan: RunPlan, end: _End) -> Outcome:
    """Return what the run tells of itself, or what is known of it."""
    try:
        outcome = Outcome.from_dict(json.loads(path.read_text()))
    except (OSError, ValueError):
        ended, reason = Ended.HUNG, "it was killed, or went on after it had been interrupted"
        if end.code >= 0:  # not by a signal
            ended, reason = Ended.DIED, f"its process ended itself, exit code {end.code}"
        script = Path(plan.folder, plan.script)
        return Outcome(script, plan.generation, ended, reason, abs(end.code) or 1)
    if end.timed_out and outcome.ended is Ended.INTERRUPTED:
        reason = "stopped by the time limit"
        return replace(outcome, ended=Ended.TIMED_OUT, reason=reason)
    return outcome


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
