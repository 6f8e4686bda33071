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
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from posflock_robotarium import testbed
from posflock_robotarium.flocking.errors import OutputError, ParameterError
from posflock_robotarium.submission.environment import (
    Environment,
    build_environment,
    cache_folder,
)
from posflock_robotarium.submission.manifest import check_manifest
from posflock_robotarium.submission.private_simulator import PRIVATE, lay_simulator
from posflock_robotarium.submission.returned_files import (
    FileState,
    ReturnedFile,
    bring_back,
    describe_file,
)
from rps_compat.scripts import import_graph

#: How robots may come to their initial conditions.
_WAYS_TO_BEGIN = ("arrive", "exact", "drive")


@dataclass(frozen=True)
class Rehearsal:
    """What came of it.

    Attributes
    ----------
    ended : str
        finished, crashed, exited, interrupted (by the duration), hung.
    seconds : float
        Of the run.
    steps, robots : int
        Done; of how many.
    folder : Path
        What came back: the files that the script wrote, and ``log.txt``.
    files : dict of str to ReturnedFile
        Each of them by name, and what was found on opening it.
    environment : Environment
        Where it ran.
    network : str
        How the network was kept away.
    faults : dict
        Steps with too near pairs, robots outside, and wheels beyond their limit.
    reason : str
        Why it crashed or exited: the line of main.py and the error; empty where it did not.
    """

    ended: str
    seconds: float
    steps: int
    robots: int
    folder: Path
    files: dict[str, ReturnedFile]
    environment: Environment
    network: str
    faults: dict[str, int] = field(default_factory=dict)
    reason: str = ""

    @property
    def passed(self) -> bool:
        """Whether the script ended by itself, or by the declared duration, and its files open."""
        good = self.ended in ("finished", "interrupted") and not self.faults.get("close_pairs")
        return good and not any(
            found.state is FileState.UNREADABLE for found in self.files.values()
        )


def rehearse(
    folder: Path | str,
    out: Path | str,
    *,
    duration: float = testbed.MAX_DURATION,
    profile: Any = "gritsbot_x",
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
        The imperfections.
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
    from rps_compat.profiles import load_profile, profile_to_dict
    from rps_compat.realism import Profile

    folder, out = Path(folder), Path(out)
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
    chosen = profile if isinstance(profile, Profile) else load_profile(profile)
    manifest = check_manifest(folder)
    names, main = list(manifest.files), manifest.main
    _empty(out)
    libraries = import_graph.trace(folder / main).libraries
    environment = environment or build_environment(libraries, tell)
    if tell is not None:
        tell(f"rehearsing {main} under Python {environment.version}")
    with tempfile.TemporaryDirectory(prefix="posflock-rehearsal-") as room:
        scratch, private = Path(room) / "upload", Path(room) / "private"
        scratch.mkdir()
        for name in names:
            shutil.copyfile(folder / name, scratch / ("main.py" if name == main else name))
        lay_simulator(private)
        plan = {
            "simulator": str(private),
            "package": PRIVATE["rps_compat"],
            "generation": generation,
            "profile": profile_to_dict(chosen) if chosen.effects else {},
            "seed": seed,
            "initial": initial,
            "duration": duration,
            "verdict": str(Path(room) / "verdict.json"),
        }
        said, network, code = _run(environment, scratch, Path(room), plan, timeout)
        uploaded = set(names) - {main} | {"main.py"}
        back = bring_back(scratch, out, uploaded, said)
        verdict = _read_verdict(Path(room) / "verdict.json", code)
    files = {name: describe_file(out / name) for name in back if name != "log.txt"}
    return Rehearsal(folder=out, files=files, environment=environment, network=network, **verdict)


def _run(
    environment: Environment, scratch: Path, room: Path, plan: dict[str, Any], timeout: float
) -> tuple[str, str, int]:
    """Run the plan; return what was said, how the network was kept away, and the exit code."""
    launcher = Path(__file__).with_name("rehearsal_launcher.py")
    (room / "plan.json").write_text(json.dumps(plan))
    command = [str(environment.python), "-I", "-B", str(launcher), str(room / "plan.json")]
    network = "socket calls refused in Python; native code is not stopped"
    if _can_unshare():
        command = ["unshare", "--map-root-user", "--net", *command]
        network = "no network: a network namespace of its own"
    kept = {name: os.environ[name] for name in ("PATH", "HOME", "LANG") if name in os.environ}
    # Into a file: a pipe would stay open as long as anything that the script left running.
    with open(room / "said.txt", "wb") as said:
        process = subprocess.Popen(
            command,
            cwd=scratch,
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
        try:
            for grace, sent in ((timeout, signal.SIGINT), (10.0, signal.SIGKILL), (None, None)):
                try:
                    process.wait(timeout=grace)
                    break
                except subprocess.TimeoutExpired:
                    assert sent is not None
                    os.killpg(process.pid, sent)
        finally:  # the run and whatever it started
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(process.pid, signal.SIGKILL)
    text = (room / "said.txt").read_text(encoding="utf-8", errors="replace")
    return text, network, process.returncode


def _can_unshare() -> bool:
    if sys.platform != "linux" or shutil.which("unshare") is None:
        return False
    command = ["unshare", "--map-root-user", "--net", "true"]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def _read_verdict(path: Path, code: int) -> dict[str, Any]:
    try:
        verdict: dict[str, Any] = json.loads(path.read_text())
    except (OSError, ValueError):
        verdict = {"ended": "hung", "seconds": 0.0, "steps": 0, "robots": 0, "faults": {}}
        verdict["reason"] = "it was killed, or went on after it had been interrupted"
        if code >= 0:  # not by a signal
            verdict |= {"ended": "exited", "reason": f"its process ended itself, exit code {code}"}
    return verdict


def _empty(out: Path) -> None:
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot write into {out}: {error}") from error
    if any(out.iterdir()):
        raise OutputError(f"{out} is not empty; choose a new folder for what comes back")


def report_on(done: Rehearsal) -> Path | None:
    """Open the pose logs that came back with the report, and return its page; None without any.

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
