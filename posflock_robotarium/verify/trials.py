"""Plan the trials of a script, have them run, hand back what became of them."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from posflock_robotarium.verify.data_files import Readable, read_back
from posflock_robotarium.verify.files import files_read
from posflock_robotarium.verify.request import Request
from posflock_robotarium.verify.source import Source
from rps_compat import testbed
from rps_compat.containment.caches import lay_font_list
from rps_compat.containment.keeper import ProcessOrder
from rps_compat.containment.kept import KeptFolder, KeptProcess
from rps_compat.containment.namespaces import (
    Containment,
    ContainmentError,
    contained,
    containment_here,
    own_folders,
)
from rps_compat.containment.room import Room
from rps_compat.containment.script_environment import script_environment
from rps_compat.containment.usage import Allowance
from rps_compat.profiles import profile_to_dict
from rps_compat.realism import Profile
from rps_compat.running.outcome import Ended, Failure, Outcome
from rps_compat.running.plan import ClockPolicy, RunPlan
from rps_compat.running.policy_violations import PolicyKind
from rps_compat.scripts.changes import Kind
from rps_compat.session import Initial

_PRELOAD = {
    "numpy": ["numpy"],
    "scipy": ["scipy.optimize", "scipy.linalg", "scipy.sparse", "scipy.spatial", "scipy.special"],
    "matplotlib": ["matplotlib.pyplot", "matplotlib.patches"],
    "cvxopt": ["cvxopt"],
    "networkx": ["networkx"],
}


@dataclass(frozen=True)
class Limits:
    """What a trial may use.

    Attributes
    ----------
    jobs : int
        Trials at a time.
    stall : float
        Seconds of computing without a step after which a trial hangs; ten times that where it
        does not compute but wait, since the machine may be busy.
    seconds : float
        Seconds of computing that a trial may take, and ten times that by the wall clock.
    memory : int
        Bytes that it may allocate.
    disk : int
        Bytes that its folder may hold.
    """

    jobs: int = max(1, os.cpu_count() or 1)
    stall: float = 20.0
    seconds: float = 300.0
    memory: int = Allowance.memory
    disk: int = Allowance.disk


@dataclass
class Ran:
    """A trial and what became of it.

    Attributes
    ----------
    outcome : Outcome
        As the trial or its supervisor tells it.
    scratch : Path
        Its working folder, as it was left.
    data : dict
        Of each file that the trial wrote or changed: whether it can be read, and how many values
        it holds.
    """

    outcome: Outcome
    scratch: Path
    data: dict[str, Readable]


class ForkServer:
    """The process that forks trials; use it in a ``with`` block to have several rooms share it.

    It starts with the first request, and again should it have died, in a containment in which only
    its own folder can be written.

    Attributes
    ----------
    containment : Containment
        What holds it.
    """

    def __init__(self) -> None:
        self.containment = containment_here()
        self._kept: KeptFolder | None = None
        self._process: KeptProcess | None = None
        self._shown: set[str] = set()

    def __enter__(self) -> ForkServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the process, and remove its folder."""
        if self._process is not None:
            self._process.end()
            self._process = None
        if self._kept is not None:
            self._kept.close()
            self._kept = None

    @property
    def folder(self) -> Path:
        """Temporary folder in which trials may have theirs."""
        if self._kept is None:
            self._kept = KeptFolder("verify")
        return self._kept.path

    def ask(self, request: Request) -> Iterator[Outcome]:
        """Yield the outcome of each trial when it is done.

        Parameters
        ----------
        request : Request
            The trials, and what each may use.
        """
        process = self._process_that_shows({path for plan in request.plans for path in plan.path})
        with contextlib.suppress(BrokenPipeError):
            process.stdin.write(request.line())
            process.stdin.flush()
        for line in iter(process.stdout.readline, ""):
            if not line.strip():
                return
            yield Outcome.from_dict(json.loads(line))

    def _process_that_shows(self, folders: set[str]) -> KeptProcess:
        """Return the process, one from which some folders can be read; start it where need be."""
        running = self._process is not None and self._process.is_running()
        if self._process is None or not running or not folders <= self._shown:
            if self._process is not None:
                self._process.end()
            self._shown |= folders
            self._process = self._start()
        return self._process

    def _start(self) -> KeptProcess:
        fonts = self.folder / "matplotlib"
        lay_font_list(Path(sys.executable), fonts)
        environment = script_environment(fonts) | {"PYTHONDONTWRITEBYTECODE": "1"}
        # The current folder comes first on the path there, and is the user's here.
        home = sys.prefix
        readable = (*own_folders(), *self._shown)
        room = Room((str(self.folder),), readable, home, as_init=True)
        command = [sys.executable, "-m", "posflock_robotarium.verify.fork_server"]
        return KeptProcess(
            ProcessOrder(contained(self.containment, room, command)),
            cwd=home,
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )


class TrialRoom:
    """A temporary folder in which trials of one script run; use it in a ``with`` block.

    Parameters
    ----------
    source : Source
        The script that is tried, with what it needs beside it.
    generation : int
        Of the API to run it under.
    limits : Limits
        What each trial may use.
    server : ForkServer, optional
        Who forks trials; one of its own by default.
    """

    def __init__(
        self, source: Source, generation: int, limits: Limits, server: ForkServer | None = None
    ) -> None:
        self.source = source
        self.generation = generation
        self.limits = limits
        self._shared = server is not None
        self._server = server or ForkServer()
        self._folder = Path(tempfile.mkdtemp(dir=self._server.folder))

    def __enter__(self) -> TrialRoom:
        return self

    def __exit__(self, *_: object) -> None:
        if self._shared:
            shutil.rmtree(self._folder, ignore_errors=True)
        else:
            self._server.close()

    @property
    def containment(self) -> Containment:
        """What holds the trials."""
        return self._server.containment

    def plan(
        self,
        name: str,
        profile: Profile | None = None,
        *,
        initial: Initial = "exact",
        seed: int = 0,
        **moments: Any,
    ) -> RunPlan:
        """Return the plan of a trial, with the script and its files laid into its own folder.

        Parameters
        ----------
        name : str
            Of the trial among others.
        profile : Profile, optional
            Its imperfections; None for none.
        initial : str
            How the robots come to their initial conditions.
        seed : int
            Of everything random.
        **moments
            When it ends, as `RunPlan` has it: longest, interrupt_at, kill_at, only_start.
        """
        scratch = self._folder / name / "scratch"
        scratch.mkdir(parents=True)
        lay_out(self.source, scratch)
        return RunPlan(
            script=os.path.join(os.path.realpath(scratch), self.source.path.name),
            folder=os.path.realpath(scratch),
            generation=1 if self.generation == 1 else 2,
            name=name,
            path=tuple(str(Path(folder).resolve()) for folder in self.source.search),
            initial=initial,
            seed=seed,
            script_seed=seed,
            profile=None if profile is None or not profile.effects else profile_to_dict(profile),
            clock=ClockPolicy.CHARGED,
            answers=(),
            # What the testbed's libraries have and newer ones dropped is there, as there.
            bridges=(Kind.LATER.value,),
            exit_functions=True,
            forbidden=(PolicyKind.OUTSIDE_WRITE, PolicyKind.FORK, PolicyKind.NETWORK),
            measures=True,
            memory=self.limits.memory,
            disk=self.limits.disk,
            **({"longest": testbed.MAX_DURATION} | moments),
        )

    def run(
        self, plans: Sequence[RunPlan], tell: Callable[[Outcome], None] | None = None
    ) -> list[Ran]:
        """Run trials, several at a time, and return them in the order of their plans.

        Parameters
        ----------
        plans : sequence of RunPlan
            One a trial, as `plan` made them.
        tell : callable, optional
            Is told of each outcome when it is there.
        """
        preload = [m for top in sorted(self.source.trace.libraries) for m in _PRELOAD.get(top, [])]
        generation = f"rps_compat.v{self.generation}"
        request = Request(
            tuple(plans),
            (
                "matplotlib.pyplot",
                "rps_compat.profiles",
                f"{generation}.drawing",
                f"{generation}.robotarium",
                *preload,
            ),
            self.limits.jobs,
            self.limits.stall,
            self.limits.seconds,
            Allowance(self.limits.memory, self.limits.disk),
        )
        found: dict[str, Outcome] = {}
        for outcome in self._server.ask(request):
            found[outcome.name] = outcome
            if tell is not None:
                tell(outcome)
        return [self._ran(plan, found.get(plan.name) or _lost(plan)) for plan in plans]

    def _ran(self, plan: RunPlan, outcome: Outcome) -> Ran:
        scratch = Path(plan.folder)
        given = {path.name for path in self.source.path.parent.iterdir() if path.is_file()}
        data = {
            name: read_back(scratch / name)
            for name in map(str, outcome.files)
            if name not in given and not name.endswith((".py", ".pyc"))
        }
        return Ran(outcome, scratch, data)


def _lost(plan: RunPlan) -> Outcome:
    """Say what is known of a trial that the fork server told nothing of."""
    error = Failure("fork server", message="no answer")
    script = Path(plan.folder, plan.script)
    return Outcome(script, plan.generation, Ended.DIED, str(error), 1, error=error, name=plan.name)


def lay_out(source: Source, scratch: Path) -> None:
    """Copy the script, its local modules and the data beside it into a folder.

    Parameters
    ----------
    source : Source
        The script, with what it needs beside it.
    scratch : Path
        Folder in which it will run.
    """
    home = source.path.resolve().parent
    shutil.copyfile(source.path, scratch / source.path.name)
    for local in source.trace.locals:
        if local.path.is_relative_to(home):
            target = scratch / local.path.relative_to(home)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(local.path, target)
    wanted = {home / path for _, path in files_read(source)}
    data = (e for e in testbed.ENDINGS if e != ".py")
    wanted |= {path for ending in data for path in home.glob(f"*{ending}")}
    for path in wanted:
        target = scratch / path.name
        if path.is_file() and path.parent == home and path.stat().st_size < 50e6:
            shutil.copyfile(path, target)


def robots_and_seconds(script: Path) -> tuple[int | None, float | None]:
    """Run a script once in the ideal simulator; return its number of robots and its length in s.

    Both are None where it does not run to its end, or where trials cannot be had.

    Parameters
    ----------
    script : Path
        The script's file.
    """
    from posflock_robotarium.verify import static
    from rps_compat.scripts.evidence import evidence_of

    _, source = static.check_source(script)
    if source is None:
        return None, None
    try:
        with TrialRoom(source, evidence_of(source.uses).generation, Limits()) as room:
            (ran,) = room.run([room.plan("ideal")])
    except ContainmentError:
        return None, None
    outcome = ran.outcome
    if outcome.ended is not Ended.FINISHED or not outcome.steps or outcome.report is None:
        return None, None
    return outcome.report.number_of_robots, outcome.time
