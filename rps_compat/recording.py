"""What one process keeps of the Robotarium instances that its script makes.

Each instance gets a :class:`Watch`, which is told of every step and passes it on: to the log
and to the film. In a child process of a script (:mod:`rps_compat.children`) it also keeps a
record of what the report needs, on disk and up to date, because such processes are often killed.
"""

import threading
import weakref
from abc import abstractmethod
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Protocol

from rps_compat.arena import Arena, Array
from rps_compat.arena_guests import Recorder
from rps_compat.film import Film
from rps_compat.report import RunReport, report_on


class RunRecorder(Recorder, Protocol):
    """A recorder that is told how the run ended; the pose log is one."""

    @abstractmethod
    def close(self, how: str, reason: str, /) -> None:
        """Take note of the end.

        Parameters
        ----------
        how : str
            How the run ended, in the words of `rps_compat.logged_end.LoggedEnd`.
        reason : str
            Why, in words; may be empty.
        """


#: Makes the recorder of one instance: where (without ending), for how many robots, and what is
#: known about the run.
OpenRecorder = Callable[[Path, int, dict[str, Any]], RunRecorder]


#: Is told of a step: seconds of the run, and the arena.
Listener = Callable[[float, Arena], None]


class Onlooker(Protocol):
    """Who looks on in the script's own process, and may hold it in its step."""

    @abstractmethod
    def created(self, robotarium: Any, /) -> None:
        """Be told of a new instance.

        Parameters
        ----------
        robotarium : Robotarium
            Of either generation; to be held weakly.
        """

    @abstractmethod
    def step(self, time: float, arena: Arena, /) -> None:
        """Be told of a step that is about to be driven, in the thread that steps.

        Parameters
        ----------
        time : float
            Of the run, s.
        arena : Arena
            As it is now; its commands are as the script gave them.
        """


class RecordWriter(Protocol):
    """Where what is known of an instance is kept up to date, step by step."""

    @abstractmethod
    def update(self, arena: Arena, /) -> None:
        """Take note of the step that the arena is about to do.

        Parameters
        ----------
        arena : Arena
            Of the instance that is recorded.
        """

    @abstractmethod
    def close(self, arena: Arena, /) -> None:
        """Take note of the arena as it is at its end.

        Parameters
        ----------
        arena : Arena
            Of the instance that is recorded.
        """


class Watch(RunRecorder):
    """Recorder of one instance.

    Parameters
    ----------
    recording : Recording
        Whose listeners are told of each step.
    log : RunRecorder or None
        Where steps are written.
    path : Path or None
        The log's path, without ending.
    record : RecordWriter or None
        What is kept for another process.

    Attributes
    ----------
    instance
        The Robotarium, where pictures are taken of it; None until it is made.
    arena
        Its arena; None until it is made.
    """

    def __init__(
        self,
        recording: "Recording",
        log: RunRecorder | None,
        path: Path | None,
        record: RecordWriter | None = None,
    ) -> None:
        self._recording, self._log, self._path, self._record = recording, log, path, record
        self.instance: Any = None
        self.arena: Arena | None = None
        self._driving_to_start = True  # as long as nothing else was seen

    def attach(self, instance: Any) -> None:
        """Watch a new instance.

        Only the first is kept, of which pictures may be taken, and that only where no record is:
        when nobody has an instance any more, its run is over. Then its log is closed, since a
        script may make thousands, and the record says so, since it may have to stand for a process
        that is killed later.

        Parameters
        ----------
        instance : Robotarium
            The new instance, of either generation.
        """
        self.arena = instance._arena
        self._tell_robot()
        if self._record is None and self._recording.watches[0] is self:
            self.instance = instance
        else:
            weakref.finalize(instance, self.close, "finished", "").atexit = False

    def append(self, time: float, poses: Array, commands: Array, /) -> None:
        """Pass one step on.

        Raises
        ------
        SystemExit
            In a thread that outlived the run: it ends the thread.
        """
        arena = self.arena
        if self._recording.over and threading.current_thread() is not threading.main_thread():
            raise SystemExit  # it outlived the run
        if self._log is not None:
            self._log.append(time, poses, commands)
            if self._driving_to_start and arena is not None:
                self._tell_drive(arena)
        if self._record is not None and arena is not None:
            self._record.update(arena)
        film = self._recording.film
        if film is not None and not film.idle and self._recording.watches[0] is self:
            film.at(time, self.instance)
        for listen in self._recording.listeners:
            assert arena is not None
            listen(time, arena)
        if self._recording.onlookers:
            assert arena is not None
            with self._recording.held():
                for onlooker in self._recording.onlookers:
                    onlooker.step(time, arena)

    def close(self, how: str, reason: str, /) -> None:
        """Close log and record; a second call changes nothing."""
        log, self._log = self._log, None
        record, self._record = self._record, None
        if record is not None and self.arena is not None:
            record.close(self.arena)
        if log is not None:
            self._tell_robot(log)  # a script may have changed its constants
            log.close(how, reason)

    def _tell_robot(self, log: RunRecorder | None = None) -> None:
        """Let the log say by which robot and arena its run is to be judged."""
        if self.arena is not None:
            self._annotate(log, robot=asdict(self.arena.robot))

    def _annotate(self, log: RunRecorder | None = None, **values: Any) -> None:
        """Add to the description of the log, where it has one."""
        annotate = getattr(log or self._log, "annotate", None)
        if annotate is not None:
            annotate(**values)

    def _tell_drive(self, arena: Arena) -> None:
        """Let the log say, in the experiment's second step, how long the drive to the start took.

        In the first, as in each step of the drive, all steps that are done were the drive's.
        """
        if arena.steps == arena.steps_to_start:
            return
        self._driving_to_start = False
        if arena.steps_to_start:
            self._annotate(drive=arena.steps_to_start * arena.robot.time_step)

    def abandon(self) -> None:
        """Leave log and record to the process from which this one was forked."""
        self._log = self._record = None

    @property
    def files(self) -> list[Path]:
        """Files of the log."""
        return [] if self._path is None else files_of(self._path)


def files_of(log: Path) -> list[Path]:
    """Return the files of a log whose path has no ending.

    Parameters
    ----------
    log : Path
        The log's path, without ending.
    """
    return sorted(path for path in log.parent.glob(f"{log.name}.*") if path.stem == log.name)


@dataclass
class Recording:
    """Makes the watches of one process.

    Attributes
    ----------
    out
        Folder for logs; None for none.
    open_log
        Opens the log of one instance; None writes none.
    about
        What every log is told of the run.
    film
        Takes pictures of the first instance.
    name
        What a log of this process is called after.
    open_record
        Opens what is kept of an instance for another process, from its number in this process,
        its number of robots, the path of its log, and whether it is a copy of the parent's.
    listeners
        Are told of each step, its time and its arena, after it was recorded; they may end the run
        by an exception, which comes out of the script's ``step()``.
    makers
        Are told of the arena of each new instance.
    onlookers
        Are told of each new instance, and of each step after the listeners.
    held
        Keeps the script's time where it is while they look.
    over
        Whether the run has ended: threads that outlived it end with their next step.
    watches : list of Watch
        Those made so far, one an instance.
    """

    out: Path | None
    open_log: OpenRecorder | None
    about: dict[str, Any]
    film: Film | None = None
    name: Callable[[], str] = lambda: ""
    open_record: Callable[[int, int, Path | None, bool], RecordWriter] | None = None
    listeners: Sequence[Listener] = ()
    makers: Sequence[Callable[[Arena], None]] = ()
    onlookers: Sequence[Onlooker] = ()
    held: Callable[[], AbstractContextManager[None]] = nullcontext
    over: bool = field(default=False, init=False)
    watches: list[Watch] = field(default_factory=list, init=False)

    def watch(self, robots: int, copied: bool = False) -> Watch:
        """Make the watch of one more instance: the session's recorder.

        Parameters
        ----------
        robots : int
            Number of its robots.
        copied : bool
            Whether it is a copy of the parent process's.
        """
        number, name = len(self.watches) + 1, self.name()
        log = path = None
        if self.open_log is not None and self.out is not None:
            words = ["poses", name, "" if number == 1 else str(number)]
            path = self.out / "-".join(filter(None, words))
            about = {**self.about, **({"process": name} if name else {})}
            log = self.open_log(path, robots, about)
        record = None
        if self.open_record is not None:
            record = self.open_record(number, robots, path, copied)
        watch = Watch(self, log, path, record)
        self.watches.append(watch)
        return watch

    def created(self, instance: Any) -> None:
        """Be told of a new instance by the session.

        Parameters
        ----------
        instance : Robotarium
            The new instance, of either generation.
        """
        watch = instance._arena.recorder
        if isinstance(watch, Watch):
            watch.attach(instance)
            for tell in self.makers:
                tell(instance._arena)
            for onlooker in self.onlookers:
                onlooker.created(instance)

    @property
    def first(self) -> Any:
        """The first instance; None while there is none."""
        return self.watches[0].instance if self.watches else None

    def reports(self) -> list[RunReport]:
        """Report on each instance, in the order of their making."""
        return [report_on(arena) for arena in self.arenas]

    @property
    def arenas(self) -> list[Arena]:
        """The arenas of the instances, in the order of their making."""
        return [watch.arena for watch in self.watches if watch.arena is not None]

    def close(self, how: str, reason: str) -> list[Path]:
        """Close all watches, and return the files of their logs.

        Parameters
        ----------
        how, reason
            How the run ended: finished, interrupted or failed, and why.
        """
        for watch in self.watches:
            watch.close(how, reason)
        return [file for watch in self.watches for file in watch.files]

    def leave_to(self, child: "Recording") -> None:
        """In a forked child, leave the recording of this process's instances to the child's own.

        They are copies of the parent's, and so are their logs, into which the parent goes on
        writing.

        Parameters
        ----------
        child : Recording
            That of the child.
        """
        for watch in self.watches:
            watch.abandon()
            if watch.arena is not None:
                watch.arena.recorder = _Continued(child, watch.arena)


class _Continued(Recorder):
    """Opens a watch for an arena that a child has from its parent, if its robots drive on."""

    def __init__(self, recording: Recording, arena: Arena) -> None:
        self._recording, self._arena = recording, arena

    def append(self, time: float, poses: Array, commands: Array, /) -> None:
        arena = self._arena
        watch = arena.recorder = self._recording.watch(arena.number_of_robots, copied=True)
        watch.arena, watch._driving_to_start = arena, False  # the drive is in the parent's log
        watch._tell_robot()
        watch.append(time, poses, commands)
