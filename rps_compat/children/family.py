"""The processes of one run, as each of them sees it."""

import atexit
import contextlib
import json
import os
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NoReturn

from rps_compat.children import VARIABLE, names
from rps_compat.children.gathering import Children, gather, terminate
from rps_compat.children.leftovers import Leftovers
from rps_compat.children.plan import Plan
from rps_compat.children.records import InstanceRecord, RobotariumInstance
from rps_compat.containment.kept import KeptFolder
from rps_compat.containment.processes import kill_users_of
from rps_compat.install import import_path
from rps_compat.logged_end import LoggedEnd
from rps_compat.own_imports import keep_apart
from rps_compat.recording import Recording
from rps_compat.session import Session

_active: "Family | None" = None


class Family:
    """One process within the run that it belongs to.

    Parameters
    ----------
    plan
        What the run has that processes started afresh must know.
    session
        Builds the instances of this process.
    recording
        Keeps what they do.

    Attributes
    ----------
    children
        What the child processes have left, when :meth:`at_home` has ended.
    """

    def __init__(self, plan: Plan, session: Session, recording: Recording) -> None:
        self._plan, self._session, self._recording = plan, session, recording
        self.children = Children()
        self._process = os.getpid()
        self._above = names.Name(plan.within, plan.entropy, plan.identity)
        self._name: names.Name | None = self._above
        self._forks = 0
        self._ended = self._cut_short = False
        self._errors: list[BaseException] = []

    # --- The script's own process --------------------------------------------------------------

    @contextlib.contextmanager
    def at_home(self) -> Iterator["Family"]:
        """Let what this process starts within the ``with`` block belong to the run."""
        global _active
        before, _active = _active, self
        self._kept = KeptFolder("run")
        self._plan = replace(self._plan, room=str(self._kept.path))
        environment = {name: os.environ.get(name) for name in ("PYTHONPATH", VARIABLE)}
        generation = import_path(self._plan.generation)
        folders = [str(generation.with_name("children")), str(generation)]
        os.environ["PYTHONPATH"] = os.pathsep.join(
            [*folders, *filter(None, [environment["PYTHONPATH"]])]
        )
        os.environ[VARIABLE] = self._plan.text()
        _hear_of_forks()
        try:
            yield self
        finally:
            _active = before
            for name, value in environment.items():
                os.environ.pop(name, None)
                if value is not None:
                    os.environ[name] = value
            if self.is_home:
                self._gather()

    def end_children(self) -> None:
        """End and gather what runs in child processes: this process ends without its script."""
        self._cut_short = True
        terminate(self._room)
        self._gather()

    def _gather(self) -> None:
        if self._cut_short:  # before: some would not end, or have only begun since
            kill_users_of(self._plan.room)
        self.children = gather(self._room)
        self._kept.close()

    @property
    def _room(self) -> Path:
        return Path(self._plan.room)

    @property
    def is_home(self) -> bool:
        """Whether this is the process in which the family began, and not a fork of it."""
        return os.getpid() == self._process

    @contextlib.contextmanager
    def ends_with_script(self) -> Iterator[None]:
        """Wait for the processes that the script of the ``with`` block has left, as Python would.

        Python does so when it exits: it ends daemons and waits for the others. After Ctrl-C and the
        time limit nobody waits.
        """
        left = Leftovers()
        try:
            yield
        except (Exception, SystemExit):
            if self.is_home:
                left.wait_for()
            raise
        except BaseException:
            if self.is_home:
                # First of all: the time limit strikes again while these take their time to end.
                self._cut_short = True
                left.end()
                terminate(self._room)
            raise
        if self.is_home:
            left.wait_for()

    # --- A child -------------------------------------------------------------------------------

    def count_fork(self) -> None:
        """Take note that this process is about to be forked."""
        if not names.is_forked_by_multiprocessing():  # which numbers its processes itself
            self._forks += 1

    def become_child(self) -> None:
        """Be what a fork of this process is: another process, with everything of its own."""
        self._above, self._name = self._name or self._above, None
        self._ended, self._forks, number = False, 0, self._forks
        before = self._recording
        self.record(replace(before, film=None))
        before.leave_to(self._recording)
        if names.is_forked_by_multiprocessing():
            self.begin_with_work()
        else:
            self.begin(self._above.of_fork(number, names.identity()).or_similar())

    def record(self, recording: Recording) -> None:
        """Let a recording keep what the instances of this child do.

        Parameters
        ----------
        recording : Recording
            Makes the watch of each instance; it gets its names and records from here.
        """
        recording.name, recording.open_record = self._name_of_logs, self._open_record
        self._recording = recording
        self._session.recorder, self._session.created = recording.watch, recording.created

    def arrive(self, as_worker: bool) -> None:
        """Belong to the run as a process that was started afresh.

        Parameters
        ----------
        as_worker
            Whether by `multiprocessing`, which tells later who it is.
        """
        global _active
        _active = self
        _hear_of_forks()
        self.record(self._recording)
        # What the script draws before any process has its work is what its own process draws.
        names.seed_generators(self._plan.seed)
        if as_worker:
            self._name = None
            self.begin_with_work()
        else:
            self.begin(self._above.of_script(sys.argv[0]))

    def begin_with_work(self) -> None:
        """Begin when `multiprocessing` has told this process who it is, before its work."""
        from multiprocessing import context, util

        util.register_after_fork(self, Family.begin)
        # A process that was started afresh says so here alone.
        context.SpawnProcess._after_fork = staticmethod(self.begin)  # type: ignore[attr-defined]

    def begin(self, candidates: Iterator[names.Name] | None = None) -> None:
        """Take a name, and random numbers of one's own, and be ready for every end.

        Parameters
        ----------
        candidates
            Of these names the first that is free; by default what follows from what
            `multiprocessing` calls this process.
        """
        works = candidates is None
        if candidates is None:
            if self._name is not None:  # somebody has made robots before
                return
            candidates = self._above.of_multiprocessing(names.identity()).or_similar()
        self._name = names.claim(self._room, candidates)
        keep_apart()  # `multiprocessing` brings a path of its own
        self._session.process, self._session.instances = self._name.entropy, 0
        names.seed_generators(self._plan.seed, self._name.entropy)
        self._plan = replace(
            self._plan,
            within=self._name.text,
            entropy=self._name.entropy,
            identity=self._name.identity,
        )
        os.environ[VARIABLE] = self._plan.text()
        if works:
            names.keep_error(self._errors)
            sys.modules["multiprocessing.util"].Finalize(None, self._end_of_work, exitpriority=0)
        else:
            atexit.register(self._end_of_script)

    def _name_of_logs(self) -> str:
        if self._name is None:  # robots are made before the work begins
            self.begin()
        assert self._name is not None
        return self._name.text

    def _open_record(
        self, number: int, robots: int, log: Path | None, copied: bool
    ) -> InstanceRecord:
        path = "" if log is None else str(log)
        instance = RobotariumInstance(self._name_of_logs(), number, robots, path, copied)
        return InstanceRecord(self._room, instance)

    def _end_of_work(self) -> None:
        self.end(*_ending(sys.exc_info()[1] or next(iter(self._errors), None)))

    def _end_of_script(self) -> None:
        self.end(*_ending(getattr(sys, "last_value", None)))

    def end(self, how: LoggedEnd, reason: str) -> None:
        """Close what this child keeps; a second call changes nothing.

        Parameters
        ----------
        how : LoggedEnd
            How the process ended.
        reason : str
            Why, in words; may be empty.
        """
        if self._ended or self._name is None or not self._room.is_dir():
            return
        self._ended = True
        self._recording.close(how, reason)
        # Whole or not there: this process may be killed while it writes.
        written = self._room / f"{self._name.text}.ending"
        written.write_text(json.dumps([how, reason]), "utf-8")
        written.replace(written.with_suffix(".end"))

    def leave(self, how: LoggedEnd, reason: str, exit_code: int) -> NoReturn:
        """End a fork of the script's process that has come to the script's end, as Python would.

        Parameters
        ----------
        how : LoggedEnd
            How the process ended.
        reason : str
            Why, in words; may be empty.
        exit_code : int
            What the process ends with.
        """
        self.end(how, reason)
        with contextlib.suppress(Exception):
            atexit._run_exitfuncs()
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(Exception):
                stream.flush()
        os._exit(exit_code)


def _ending(error: BaseException | None) -> tuple[LoggedEnd, str]:
    """How a process ended that ended by `error`, and why."""
    if error is None or (isinstance(error, SystemExit) and not error.code):
        return LoggedEnd.FINISHED, ""
    if isinstance(error, KeyboardInterrupt):
        return LoggedEnd.INTERRUPTED, "KeyboardInterrupt"
    return LoggedEnd.FAILED, f"{type(error).__name__}: {error}"


def has_family() -> bool:
    """Whether this process belongs to a run."""
    return _active is not None


_listening = False


def _hear_of_forks() -> None:
    """Have forks of this process told of, once and for all: such a wish cannot be taken back."""
    global _listening
    if not _listening and hasattr(os, "register_at_fork"):
        os.register_at_fork(before=_count_fork, after_in_child=_be_child)
        _listening = True


def _count_fork() -> None:
    if _active is not None:
        _active.count_fork()


def _be_child() -> None:
    if _active is not None:
        _active.become_child()
