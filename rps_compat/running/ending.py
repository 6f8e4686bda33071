"""How a script ends: by itself, with all its threads, by an exception, by its time limit.

Plain Python waits at the end of a script for every thread that is not a daemon, even for ever.
So does a run, in simulated time; but where all that is left waits for ever, or the time limit is
over, it ends and says why.

The limit is kept by a thread. It sends the main thread a signal whose handler raises
:class:`OutOfTime`, again and again, since a bare ``except:`` may swallow the first. A main thread
that is lost in C code, or swallows them all, is given up: the command line then writes the report
from the other thread and ends the process. `run_script` cannot do so, since the process is not its
own.
"""

import contextlib
import math
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import NoReturn

from barrier_certificates.certificate_errors import OutputError
from rps_compat.clock import Stuck, real
from rps_compat.errors import ScriptError
from rps_compat.last_resort import last_resort
from rps_compat.own_imports.whose import environments_module
from rps_compat.running.failures import failure_of
from rps_compat.running.outcome import Ended, Failure
from rps_compat.running.schedule import Enough
from rps_compat.terminal import reader_is_gone

#: Exit codes of a run that the script does not end itself, the first four as shells have them.
EXIT_CODES: dict[Ended, int] = {
    Ended.FINISHED: 0, Ended.FAILED: 1, Ended.INTERRUPTED: 130, Ended.TIMED_OUT: 124,
    Ended.HUNG: 3, Ended.IDLE: 4, Ended.OUT_OF_MEMORY: 1, Ended.OVER_TIME: 124, Ended.STOPPED: 0,
}  # fmt: skip
#: Real seconds between two signals of the time limit, and how many the main thread gets.
AGAIN, TRIES = 0.25, 8
#: Real seconds after the limit when a process that may be ended is, without a report.
LAST_RESORT = 15.0
#: Real seconds that a process which ends without waiting may take to write what was printed.
FLUSH = 5.0


class OutOfTime(BaseException):
    """The time limit of a run is over; not an Exception, so that scripts do not swallow it."""


@dataclass(frozen=True)
class End:
    """How a script ended; see `Outcome`.

    Attributes
    ----------
    ended : Ended
        The kind of end.
    reason : str
        Why, in words; may be empty.
    exit_code : int
        What the process ends with.
    error : Failure, optional
        What its exception says.
    """

    ended: Ended
    reason: str
    exit_code: int
    error: Failure | None = None

    @classmethod
    def of(cls, ended: Ended, reason: str = "", error: Failure | None = None) -> "End":
        """Return the end of a kind that has an exit code of its own.

        Parameters
        ----------
        ended : Ended
            The kind of end.
        reason : str
            Why, in words.
        error : Failure, optional
            What its exception says.
        """
        return cls(ended, reason, EXIT_CODES[ended], error)


def end_of(
    run: Callable[[], object],
    script: Path,
    limit: "TimeLimit",
    leftovers: contextlib.AbstractContextManager[None],
) -> End:
    """Call `run`, wait for the threads that it leaves, and tell how it ended.

    The traceback of an exception is printed to stderr from where it comes through `script`.

    Parameters
    ----------
    run
        Runs the script.
    script
        The file that `run` runs.
    limit
        What stops it.
    leftovers
        Waits, when it is left, for what else the script leaves, or ends that.
    """
    before = set(threading.enumerate())
    end = End.of(Ended.FINISHED)
    try:
        with limit, leftovers:
            try:
                run()
            except Exception as error:
                end = _failed(error, script)
            except SystemExit as left:
                end = _exit_of(left, script)
            wait_for_threads(before)
    except OutOfTime:
        return limit.end
    except Enough:
        return End.of(Ended.STOPPED)
    except KeyboardInterrupt as error:
        what = failure_of(error, script.parent)
        return End.of(Ended.INTERRUPTED, "KeyboardInterrupt", what)
    except Stuck as stuck:
        if end.exit_code:
            return end
        return End.of(Ended.HUNG, str(stuck), failure_of(stuck, script.parent))
    except BaseException as error:
        return _failed(error, script)
    return end


def _failed(error: BaseException, script: Path) -> End:
    if isinstance(error, OutputError):  # the disk's fault, at whatever line of the script
        print(f"{script.name}: {error}", file=sys.stderr)
    elif not (isinstance(error, BrokenPipeError) and reader_is_gone()):
        _print_traceback(error, script)
    ended = Ended.OUT_OF_MEMORY if isinstance(error, MemoryError) else Ended.FAILED
    reason = f"{type(error).__name__}: {error}"
    return End.of(ended, reason, failure_of(error, script.parent))


def _exit_of(left: SystemExit, script: Path) -> End:
    if left.code is None or left.code == 0:
        return End.of(Ended.FINISHED)
    what = failure_of(left, script.parent)
    if isinstance(left.code, int):
        reason = f"the script left with exit code {left.code}"
        return End(Ended.FAILED, reason, left.code, what)
    with contextlib.suppress(OSError):  # nobody takes it: the disk is full, or the reader gone
        print(left.code, file=sys.stderr)
    return End.of(Ended.FAILED, str(left.code), what)


def _print_traceback(error: BaseException, script: Path) -> None:
    frames = error.__traceback__
    while frames is not None and script.parent / frames.tb_frame.f_code.co_filename != script:
        frames = frames.tb_next
    with contextlib.suppress(OSError):
        traceback.print_exception(type(error), error, frames or error.__traceback__)


def lasting_threads(before: set[threading.Thread]) -> list[threading.Thread]:
    """List the threads for which Python waits at the end.

    Parameters
    ----------
    before : set of Thread
        Threads that do not count, since they were there before the script.
    """
    here = {*before, threading.current_thread()}
    return [thread for thread in threading.enumerate() if thread not in here and not thread.daemon]


def wait_for_threads(before: set[threading.Thread]) -> None:
    """Wait for the threads that a script leaves, as Python does at its end.

    Parameters
    ----------
    before : set of Thread
        Threads that do not count, since they were there before the script.
    """
    pools = (("concurrent.futures.thread", "_shutdown", _dismiss_threads),
             ("concurrent.futures.process", "_global_shutdown", _dismiss_processes))  # fmt: skip
    known = [(module, flag, dismiss) for name, flag, dismiss in pools
             if (module := environments_module(name)) is not None]  # fmt: skip
    try:
        for module, flag, dismiss in known:
            setattr(module, flag, True)
            dismiss(module, before)
        while left := lasting_threads(before):
            left[0].join()
    finally:  # the process may go on
        for module, flag, _ in known:
            setattr(module, flag, False)


def _dismiss_threads(module: object, before: set[threading.Thread]) -> None:
    """Let idle threads of pools end, as Python does when it ends."""
    for thread, tasks in list(getattr(module, "_threads_queues", {}).items()):
        if thread not in before:
            tasks.put(None)


def _dismiss_processes(module: object, before: set[threading.Thread]) -> None:
    """Let the threads that keep pools of processes end them."""
    for thread, wakeup in list(getattr(module, "_threads_wakeups", {}).items()):
        if thread not in before:
            wakeup.wakeup()


class TimeLimit:
    """Raises OutOfTime in the main thread after so many real seconds; use it in a ``with`` block.

    Parameters
    ----------
    seconds
        None or infinity limits nothing.
    give_up
        Is called in another thread when the main thread does not stop, and must end the process;
        None goes on telling it.

    Raises
    ------
    ScriptError
        There is a limit, but no POSIX signals, or this is not the main thread.
    """

    def __init__(self, seconds: float | None, give_up: Callable[[], object] | None = None) -> None:
        self._seconds = math.inf if seconds is None else seconds
        self._give_up = give_up
        self._guard, self._over = real.allocate_lock(), real.allocate_lock()
        self._left, self._last = False, contextlib.ExitStack()
        here = threading.current_thread() is threading.main_thread()
        if math.isfinite(self._seconds) and not (here and hasattr(signal, "SIGXCPU")):
            raise ScriptError("a time limit needs the main thread of a POSIX system")

    @property
    def end(self) -> End:
        """The end of a script that the limit stopped."""
        return End.of(Ended.TIMED_OUT, f"stopped by the time limit of {self._seconds:g} s")

    def __enter__(self) -> "TimeLimit":
        if math.isfinite(self._seconds):
            self._over.acquire()
            if self._give_up is not None:
                code = EXIT_CODES[Ended.TIMED_OUT]
                self._last.enter_context(last_resort(self._seconds + LAST_RESORT, code))
            self._before = signal.signal(signal.SIGXCPU, self._stop)
            real.start_new_thread(self._watch, (real.get_ident(),))
        return self

    def __exit__(self, *_: object) -> None:
        if math.isfinite(self._seconds):
            with self._guard:
                self._left = True
            self._over.release()
            signal.signal(signal.SIGXCPU, self._before)
            self._last.close()

    def _stop(self, number: int, frame: FrameType | None) -> None:
        if not self._left:
            raise OutOfTime

    def _watch(self, main: int) -> None:
        wait, tries = self._seconds, 0
        while not self._over.acquire(True, min(wait, threading.TIMEOUT_MAX)):
            with self._guard:
                if self._left:
                    return
                if tries >= TRIES and self._give_up is not None:
                    try:
                        self._give_up()
                    finally:
                        end_process(self.end.exit_code)
                signal.pthread_kill(main, signal.SIGXCPU)
            wait, tries = AGAIN, tries + 1


def leave(exit_code: int, before: set[threading.Thread]) -> None:
    """End this process at once if Python would wait for threads or processes of the script.

    Parameters
    ----------
    exit_code
        Of the process.
    before
        The threads that are not the script's.
    """
    multiprocessing = environments_module("multiprocessing")
    children = [] if multiprocessing is None else multiprocessing.active_children()
    if children or lasting_threads(before):
        for child in children:
            child.terminate()
        end_process(exit_code)


def end_process(exit_code: int) -> NoReturn:
    """End this process without waiting for anybody, once what was printed is out.

    Parameters
    ----------
    exit_code : int
        What the process ends with.
    """
    real.start_new_thread(lambda: (real.sleep(FLUSH), os._exit(exit_code)), ())
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(Exception):
            stream.flush()
    os._exit(exit_code)
