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
import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from posflock_robotarium.flocking.errors import OutputError, ParameterError, PosflockError
from posflock_robotarium.submission.bundle import check_manifest, main_file
from posflock_robotarium.submission.interpreters import installed_pythons
from rps_compat import testbed
from rps_compat.scripts import import_graph
from rps_compat.scripts.libraries import IMPORT_NAMES, LIBRARIES, PYTHON

#: Always installed; heavier ones only where the bundle imports them.
_BASE = ("numpy", "scipy", "matplotlib", "cvxopt")
#: How robots may come to their initial conditions.
_WAYS_TO_BEGIN = ("arrive", "exact", "drive")
_PRIVATE = {"rps_compat": "_rehearsal_rps", "barrier_certificates": "_rehearsal_certificates"}


class RehearsalError(PosflockError):
    """The rehearsal environment cannot be built or started."""


@dataclass(frozen=True)
class Environment:
    """A cached copy of the testbed's Python.

    Attributes
    ----------
    python : Path
        Its interpreter.
    version : str
        Of that interpreter.
    libraries : dict
        Installed versions of what was asked for.
    note : str
        How it differs from the testbed; empty where it does not.
    """

    python: Path
    version: str
    libraries: dict[str, str]
    note: str = ""


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
    files : dict of str to str
        Each of them, and what was found on opening it.
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
    files: dict[str, str]
    environment: Environment
    network: str
    faults: dict[str, int] = field(default_factory=dict)
    reason: str = ""

    @property
    def passed(self) -> bool:
        """Whether the script ended by itself, or by the declared duration, and its files open."""
        good = self.ended in ("finished", "interrupted") and not self.faults.get("close_pairs")
        return good and not any(text.startswith("unreadable") for text in self.files.values())


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
    names, main = check_manifest(folder), main_file(folder)
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
            "package": _PRIVATE["rps_compat"],
            "generation": generation,
            "profile": profile_to_dict(chosen) if chosen.effects else {},
            "seed": seed,
            "initial": initial,
            "duration": duration,
            "verdict": str(Path(room) / "verdict.json"),
        }
        said, network, code = _run(environment, scratch, Path(room), plan, timeout)
        uploaded = set(names) - {main} | {"main.py"}
        back = _bring_back(scratch, out, uploaded, said)
        verdict = _read_verdict(Path(room) / "verdict.json", code)
    files = {name: describe_file(out / name) for name in back if name != "log.txt"}
    return Rehearsal(folder=out, files=files, environment=environment, network=network, **verdict)


# --- The environment ---------------------------------------------------------------------------


def build_environment(
    libraries: Iterable[str], tell: Callable[[str], None] | None = None
) -> Environment:
    """Return a cached environment that has the testbed's version of these libraries.

    Parameters
    ----------
    libraries : iterable of str
        Import names; those of the standard library do not matter.
    tell : callable, optional
        Is told when one is being built, which takes a minute.
    """
    wanted = {IMPORT_NAMES[name] for name in libraries if name in IMPORT_NAMES}
    pins = [
        f"{name}=={version}" if version else name
        for name, version in LIBRARIES.items()
        if name in wanted or name in _BASE
    ]
    base, note = _nearest_python()
    key = hashlib.sha256("\n".join([str(base), *pins]).encode()).hexdigest()[:16]
    folder = _cache() / f"testbed-{key}"
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if not (folder / "ready").exists():
        if tell is not None:
            tell(f"building the rehearsal environment, once: {', '.join(pins)}")
        _build(base, folder, python, pins)
    program = (
        "import json, platform; from importlib.metadata import version;"
        f"print(json.dumps([platform.python_version(), {{n: version(n) for n in"
        f" {[pin.partition('==')[0] for pin in pins]!r}}}]))"
    )
    version, installed = json.loads(
        subprocess.run(
            [str(python), "-I", "-c", program], capture_output=True, text=True, check=True
        ).stdout
    )
    return Environment(python, version, installed, note)


def _nearest_python() -> tuple[Path, str]:
    """Return the testbed's Python, or the nearest there is with a note that says so."""
    pythons = installed_pythons()
    if PYTHON in pythons:
        return pythons[PYTHON], ""
    nearest = min((v for v in pythons if v >= (3, 10)), key=lambda v: abs(v[1] - PYTHON[1]))
    return pythons[nearest], (
        f"the testbed runs Python {PYTHON[0]}.{PYTHON[1]}, which is not installed"
        f" here: rehearsed with {nearest[0]}.{nearest[1]}, which accepts newer syntax"
    )


def _cache() -> Path:
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path.home() / ".cache") / "posflock"


def _build(base: Path, folder: Path, python: Path, pins: list[str]) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    commands = [
        [str(base), "-m", "venv", str(folder)],
        [str(python), "-m", "pip", "install", "-q", "--disable-pip-version-check", *pins],
    ]
    for command in commands:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            shutil.rmtree(folder, ignore_errors=True)
            last = (done.stderr.strip().splitlines() or ["no reason given"])[-1]
            raise RehearsalError(
                f"cannot build the rehearsal environment: `{' '.join(command[1:4])} …` ended with"
                f" {last!r}; it needs the package index once"
            )
    (folder / "ready").write_text("\n".join(pins) + "\n")


def lay_simulator(folder: Path) -> None:
    """Copy the simulator into `folder` under private names.

    The bundle brings its own ``barrier_certificates`` and must find those, not the simulator's.
    """
    import barrier_certificates
    import rps_compat

    for package in (rps_compat, barrier_certificates):
        home = Path(str(package.__file__)).parent
        target = folder / _PRIVATE[package.__name__]
        for path in sorted(home.rglob("*")):
            if path.is_dir() or "__pycache__" in path.parts or "import_paths" in path.parts:
                continue
            copy = target / path.relative_to(home)
            copy.parent.mkdir(parents=True, exist_ok=True)
            if path.suffix == ".py":
                copy.write_text(_renamed(path.read_text(encoding="utf-8")), encoding="utf-8")
            else:
                shutil.copyfile(path, copy)


def _renamed(source: str) -> str:
    """Return source in which our two packages go by their private names.

    ``rps.utilities.barrier_certificates`` is a module of the API and keeps its name: only what is
    imported as a top-level name, or named so in a string, is renamed.
    """
    for name, private in _PRIVATE.items():
        source = re.sub(rf"(?m)^(\s*(?:from|import)\s+){name}\b", rf"\g<1>{private}", source)
        source = re.sub(rf"(f?[\"']){name}(?=[.\"'])", rf"\g<1>{private}", source)
    return source


# --- The run -----------------------------------------------------------------------------------


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
                "MPLCONFIGDIR": str(_cache() / "matplotlib"),
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


def _bring_back(scratch: Path, out: Path, uploaded: set[str], said: str) -> list[str]:
    """Copy what the script wrote into `out`, as the testbed returns it."""
    (out / "log.txt").write_text(said, encoding="utf-8")
    back = ["log.txt"]
    for path in sorted(scratch.rglob("*")):
        name = str(path.relative_to(scratch))
        if path.is_file() and name not in uploaded and "__pycache__" not in path.parts:
            (out / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, out / name)
            back.append(name)
    return back


def describe_file(path: Path) -> str:
    """Open a returned file and say what it is; "unreadable" first where it cannot be."""
    from posflock_robotarium.flocking.errors import LogError
    from posflock_robotarium.logs.readers import read_pose_log
    from posflock_robotarium.verify.trials import read_back

    if path.suffix == ".npy":
        try:
            log = read_pose_log(path)
        except LogError:
            pass
        else:
            end = "unknown" if log.ending is None else log.ending.how.value
            last = f"{log.t[-1]:.1f} s"
            return f"pose log of {log.robots} robots, {len(log.t)} rows until {last}, {end}"
    content = read_back(path)
    if not content.readable:
        return f"unreadable ({content.size} bytes)"
    return f"readable, {content.size} bytes"


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
        done.folder / name for name, found in done.files.items() if found.startswith("pose log")
    ]
    if not logs:
        return None
    written = write_report([analyse(log) for log in logs], done.folder / "report", figures=False)
    return Path(written[0])
