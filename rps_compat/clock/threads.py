"""What the clock knows of one thread of the script, and what the system says that it is doing.

A thread that waits in simulated time says so, and is ``WAITING``. One that says that it waits for
the world outside, another process or a socket, is ``OUTSIDE``. Everything else is ``RUNNING``, and
what that means has to be found out: it may compute, or hang in a wait that nobody told the clock
of, such as ``sys.stdin.read()``. The system knows: a thread that sleeps in the kernel, and whose
CPU time stands still, does not compute. One that is only kept from the processor by a busy machine
is not asleep, so that load makes no difference.
"""

import os
import sys
import threading
import weakref
from enum import Enum
from typing import Protocol

from rps_compat.clock import real

#: CPU seconds within which a woken thread should come to its next wait: so long time stands still.
TURN = 0.02
#: Looks in a row that find a thread asleep before it is believed to hang in an unknown wait.
LOOKS = 3
#: What keeps a thread that hangs in an unknown wait, in words for people.
IN_C = "waits inside C code"


class State(Enum):
    """What a thread is doing, as far as the clock was told."""

    RUNNING = 1
    WAITING = 2
    OUTSIDE = 3


class Blocker(Protocol):
    """What a thread blocks in, to those who know but the thread.

    Attributes
    ----------
    failure
        What to raise in the thread.
    """

    failure: BaseException | None

    def release(self) -> None:
        """Wake the thread."""

    def fire(self) -> None:
        """End the wait as its deadline would."""

    def ring(self) -> None:
        """Let the thread look around."""


class ScriptThread:
    """One thread of the script.

    Parameters
    ----------
    thread : object
        As Python knows it, or whatever stands for a thread that was started below `threading`.
    started_at : str
        Where the script started it, for messages.

    Attributes
    ----------
    ident, native
        Python's and the system's number of it; None until it runs.
    wait
        What it waits for in simulated time, if it does.
    turn
        Whether it has just been woken, and time stands still until it waits again.
    asks
        Whether it asked the world outside for something that was not there yet.
    engine
        What moves time on in this thread, while it does.
    joiners
        What others wait in for its end.
    short_waits
        How many waits in a row took next to no time.
    since
        When it began to wait for the world outside, by the real clock.
    reason
        What of the world outside it waits for or asks, in words for people.
    """

    def __init__(self, thread: object, started_at: str = "") -> None:
        self.thread, self.started_at = thread, started_at
        self.ident: int | None = None
        self.native: int | None = None
        self.state = State.RUNNING
        self.wait: Blocker | None = None
        self.engine: Blocker | None = None
        self.joiners: list[Blocker] = []
        self._pipe: tuple[int, int] | None = None
        self.asks, self.short_waits, self.reason = False, 0, IN_C
        self.since = self._seen = 0.0
        self.begin_turn()

    def arrive(self) -> None:
        """Take note that this thread is the running one."""
        self.ident, self.native = real.get_ident(), threading.get_native_id()
        self.begin_turn()

    def bell(self) -> tuple[int, int]:
        """Return both ends of a pipe by which the thread is rung while it polls descriptors."""
        if self._pipe is None:
            self._pipe = os.pipe()
            os.set_blocking(self._pipe[1], False)
            weakref.finalize(self, _close, self._pipe)
        return self._pipe

    def begin_turn(self) -> None:
        """Give the thread its chance to come to its next wait."""
        self.turn, self.asleep = True, 0
        self._from = real.monotonic()
        self._cpu = self._cpu_before = cpu_seconds(self.native)

    def glance(self, elapsed: float, look: float) -> float:
        """Return the time that the thread sees, which a look does not move on.

        Yet no two looks see the same, since code counts on that: until time moves, each sees `look`
        seconds more than the one before, up to a thousand of them.

        Parameters
        ----------
        elapsed : float
            Simulated time, s.
        look : float
            How much a look adds, s.
        """
        self._seen = max(elapsed, min(self._seen + look, elapsed + 1000 * look))
        return self._seen

    @property
    def name(self) -> str:
        """As messages call it."""
        if self.thread is threading.main_thread():
            return "the main thread"
        return self.thread.name if isinstance(self.thread, threading.Thread) else "a thread"

    @property
    def gone(self) -> bool:
        """Whether the thread has ended without a word."""
        return self.ident is not None and self.ident not in sys._current_frames()

    def look(self) -> None:
        """Find out what the thread does: ends its turn when it is used up, counts it asleep."""
        if self.ident is None:  # it has not begun
            return
        cpu = cpu_seconds(self.native)
        if cpu is None or self._cpu is None:
            if real.monotonic() - self._from > TURN:
                self.turn = False
            self._cpu = self._cpu_before = cpu
            return
        stirs = cpu != self._cpu
        self.asleep = 0 if stirs or not sleeps(self.native) else self.asleep + 1
        self._cpu = cpu
        if self._cpu_before is None or cpu - self._cpu_before > TURN:
            self.turn = False

    def stirs(self) -> bool:
        """Whether a thread that hung in an unknown wait has gone on since it was last looked at."""
        return cpu_seconds(self.native) != self._cpu


def _close(pipe: tuple[int, int]) -> None:
    for end in pipe:
        os.close(end)


def cpu_seconds(native: int | None) -> float | None:
    """CPU time of a thread of this process by its system number; None where nobody tells.

    Parameters
    ----------
    native : int or None
        The system's number of the thread.
    """
    if native is None or sys.platform != "linux" or real.clock_gettime is None:
        return None
    try:
        # The kernel's number of a thread's CPU clock; unlike pthread_getcpuclockid, it may be
        # asked after the thread's end.
        return float(real.clock_gettime((~native << 3) | 6))
    except OSError:
        return None


def sleeps(native: int | None) -> bool:
    """Whether the kernel has put a thread of this process to sleep until something happens.

    Parameters
    ----------
    native : int or None
        The system's number of the thread.
    """
    try:
        file = os.open(f"/proc/self/task/{native}/stat", os.O_RDONLY)
        try:
            status = os.read(file, 512)
        finally:
            os.close(file)
    except OSError:
        return False
    return status.rpartition(b") ")[2][:1] == b"S"
