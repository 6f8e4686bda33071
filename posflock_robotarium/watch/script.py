"""The script's process as its starter sees it: its folder, what holds it, what it tells.

The script runs from a copy of its own, with the modules and the data beside it, in a temporary
folder that ends with the command. What it wrote is brought out at its end, where somebody asked
for it.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

from posflock_robotarium.flocking.errors import OutputError
from posflock_robotarium.verify.source import Source
from posflock_robotarium.verify.trials import lay_out
from posflock_robotarium.watch.requests import PageRequest, Stop
from posflock_robotarium.watch.settings import Settings
from rps_compat.containment.caches import lay_font_list
from rps_compat.containment.keeper import ProcessOrder
from rps_compat.containment.kept import KeptProcess
from rps_compat.containment.namespaces import contained, containment_here, own_folders
from rps_compat.containment.room import Room
from rps_compat.containment.script_environment import script_environment
from rps_compat.containment.usage import Allowance
from rps_compat.generations import Generation
from rps_compat.profiles import profile_to_dict
from rps_compat.realism import Profile
from rps_compat.running.ending import EXIT_CODES
from rps_compat.running.outcome import Ended, Outcome
from rps_compat.running.plan import ClockPolicy, RunPlan
from rps_compat.running.policy_violations import PolicyKind
from rps_compat.running.watching import Listener, new_word
from rps_compat.scripts.changes import Kind
from rps_compat.scripts.source import read_script
from rps_compat.session import Initial
from rps_compat.whole_files import remove_listed, written_together

#: What the script's processes may use; libraries may be large.
_ALLOWANCE = Allowance(memory=4 << 30)


@dataclass(frozen=True)
class WatchJob:
    """What is run: all that does not change while it is watched.

    Attributes
    ----------
    script : Path
        The script's file.
    generation : int
        Of the API.
    profiles : mapping of str to Profile
        Those that may be asked for.
    arguments : tuple of str
        The script's own.
    initial : str
        How the robots come to their initial conditions; see `rps_compat.session.Session`.
    seed : int, optional
        Of all that is random.
    answers : tuple of str
        What ``input()`` answers, after which it answers an empty line.
    radius : float, optional
        Who is a neighbour where no flock tells, m.
    notes : tuple of str
        What is known of the script before it runs.
    """

    script: Path
    generation: Generation
    profiles: Mapping[str, Profile]
    arguments: tuple[str, ...] = ()
    initial: Initial = "published"
    seed: int | None = None
    answers: tuple[str, ...] = ()
    radius: float | None = None
    notes: tuple[str, ...] = ()


@dataclass
class ScriptEars:
    """What is to be called with what the process says.

    Attributes
    ----------
    more : callable
        Is given the kind and the JSON of what is shown.
    printed : callable
        Is given what the script prints, piece by piece.
    """

    more: Callable[[str, str], None]
    printed: Callable[[str], None] = field(default=lambda text: None)


class ScriptProcess:
    """One run of a script, in a folder and a process of its own.

    Parameters
    ----------
    job : WatchJob
        What is run.
    settings : Settings
        How it begins.
    folder : Path
        A folder of its own, which does not exist yet.
    heard : ScriptEars
        Who is told what it says.

    Attributes
    ----------
    scratch, log : Path
        Where the script runs; where the run's own files are.
    plan : RunPlan
        How it is run.
    told : Listener
        What the run has told.
    silent : bool
        Whether nobody is left who could print anything.
    """

    def __init__(self, job: WatchJob, settings: Settings, folder: Path, heard: ScriptEars) -> None:
        self._job, self._heard = job, heard
        self.scratch, self.log = folder / "script", folder / "log"
        # Records of the script's children are kept in the second.
        fonts, temporary = folder / "matplotlib", folder / "tmp"
        for place in (self.scratch, self.log, temporary):
            place.mkdir(parents=True)
        lay_font_list(Path(sys.executable), fonts)
        lay_out(Source(read_script(job.script), job.generation), self.scratch)
        self._given = {str(path.relative_to(self.scratch)) for path in self.scratch.rglob("*")}
        self.plan = _plan(job, settings, self.scratch, (self.log, fonts, temporary))
        ear, mouth = os.pipe()
        self._closed = self._interrupted = self.silent = False
        self.told = Listener(ear, new_word(), more=heard.more)
        self._process = self._started(fonts, temporary, mouth)
        os.close(mouth)
        os.set_blocking(self.printed, False)
        order = {
            "plan": asdict(self.plan),
            "pipe": mouth,
            "word": self.told.word,
            "settings": settings.as_dict(),
            "profiles": {n: profile_to_dict(p) for n, p in job.profiles.items()},
            "radius": job.radius,
            "notes": list(job.notes),
        }
        self._send(json.dumps(order))

    def _started(self, fonts: Path, temporary: Path, mouth: int) -> KeptProcess:
        writable = (str(self.scratch), *self.plan.writable)
        room = Room(writable, own_folders(), str(self.scratch))
        command = [sys.executable, "-m", "posflock_robotarium.watch.child"]
        return KeptProcess(
            ProcessOrder(contained(containment_here(), room, command)),
            cwd=self.scratch,
            env=script_environment(fonts)
            | {
                "PYTHONSAFEPATH": "1",
                "PYTHONUNBUFFERED": "1",
                "PYTHONIOENCODING": "utf-8:backslashreplace",
                "TMPDIR": str(temporary),
            },
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            pass_fds=(mouth,),
        )

    @property
    def printed(self) -> int:
        """Descriptor from which is read what the script prints."""
        return self._process.stdout.fileno()

    def hear(self) -> None:
        """Hand on what the run has told and the script has printed since."""
        self.told.hear()
        while True:
            try:
                block = os.read(self.printed, 1 << 16)
            except (OSError, ValueError):  # nothing yet, or it is closed
                return
            if not block:
                self.silent = True
                return
            self._heard.printed(block.decode("utf-8", "replace"))

    def ask(self, request: PageRequest) -> None:
        """Hand a request to the run.

        Parameters
        ----------
        request : PageRequest
            What is asked.
        """
        self._send(request.text())

    def _send(self, line: str) -> None:
        try:
            self._process.stdin.write(line + "\n")
            self._process.stdin.flush()
        except (BrokenPipeError, ValueError):
            pass  # it has ended, of which the outcome will tell

    def is_running(self) -> bool:
        """Whether it, or anything that it has started, still runs."""
        return self._process.is_running()

    def outcome(self) -> Outcome:
        """Wait until the process has ended, with all that it started, and tell how the run went."""
        code = -signal.SIGKILL if self._closed else self._process.wait().code
        self.kill()
        if self.told.said is not None:
            return self.told.said
        ended, reason = Ended.DIED, f"its process ended itself, exit code {code}"
        if self._interrupted and code < 0:
            ended, reason = Ended.INTERRUPTED, "interrupted, it did not end, and was killed"
        elif code < 0 or code > 128:
            reason = "it was killed"
        return Outcome(
            self._job.script,
            self.plan.generation,
            ended,
            reason,
            EXIT_CODES[ended] if ended in EXIT_CODES else abs(code) or 1,
            policy_violations=tuple(self.told.violations),
        )

    def interrupt(self) -> None:
        """Ask the script to end, as Ctrl-C does."""
        self._interrupted = True
        self.ask(Stop())

    def kill(self) -> None:
        """End the process with all that it has started; a second call does nothing."""
        self._process.end()
        if not self._closed:
            self._closed = True
            self.told.close()

    def bring_out(self, out: Path, before: list[str]) -> list[str]:
        """Put what the run left into a folder, in the place of what an earlier one left.

        Parameters
        ----------
        out : Path
            The folder; the files that the script itself wrote go into ``script`` in it.
        before : list of str
            Names of files in it that go.

        Returns
        -------
        list of str
            Names of the files there.

        Raises
        ------
        OutputError
            The folder cannot be written.
        """
        found = {str(path.relative_to(self.log)): path for path in _files(self.log)}
        for path in _files(self.scratch):
            name = str(path.relative_to(self.scratch))
            if name not in self._given and "__pycache__" not in path.parts:
                found[os.path.join("script", name)] = path
        try:
            remove_listed(out, before)
            with written_together(out) as draft:
                for name, path in found.items():
                    (draft / name).parent.mkdir(parents=True, exist_ok=True)
                    shutil.copyfile(path, draft / name)
        except OSError as error:
            raise OutputError(f"cannot write into {out}: {error}") from error
        return sorted(found)


def _files(folder: Path) -> list[Path]:
    """Return the plain files in a folder: a link may lead anywhere."""
    return [path for path in sorted(folder.rglob("*")) if path.is_file() and not path.is_symlink()]


def _plan(job: WatchJob, settings: Settings, scratch: Path, writable: tuple[Path, ...]) -> RunPlan:
    profile = job.profiles[settings.profile]
    return RunPlan(
        script=str(scratch / job.script.name),
        folder=str(scratch),
        generation=job.generation,
        arguments=job.arguments,
        initial=job.initial,
        seed=job.seed,
        script_seed=job.seed,
        profile=profile_to_dict(profile) if profile.effects else None,
        clock=ClockPolicy.SIMULATED,
        draws_on_demand=True,
        answers=job.answers,
        bridges=(Kind.GONE.value, Kind.LATER.value),
        children=True,
        exit_functions=True,
        forbidden=(PolicyKind.OUTSIDE_WRITE, PolicyKind.NETWORK),
        memory=_ALLOWANCE.memory,
        disk=_ALLOWANCE.disk,
        out=str(writable[0]),
        writable=tuple(map(str, writable)),
    )
