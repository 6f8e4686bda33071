"""Which threads the script has, which of them run, and which one moves time on."""

from __future__ import annotations

import threading

from rps_compat.clock import real
from rps_compat.clock.threads import IN_C, LOOKS, ScriptThread, State
from rps_compat.clock.waits import Wait, Waker

#: Real seconds after which who waits for others looks at what they do.
LOOK_AGAIN = 0.001


class Roster(Waker):
    """The threads of one script.

    Attributes
    ----------
    lock
        Held by whoever reads or changes anything here.
    main
        The thread that runs the script.
    stepper
        The thread that moves time on.
    threads
        Those that have begun, by their idents.
    foreign
        Idents of threads that are not the script's, and keep the real time.
    starting
        Those that have been started and have not begun.
    busy
        Those that run, without the stepper.
    out
        Those that wait for the world outside, or for something unknown.
    """

    def __init__(self) -> None:
        self._begin()

    def _begin(self) -> None:
        """Know of nobody but the running thread: at the start, and in a forked process."""
        self.lock = real.reentrant_lock()
        self.main = self.stepper = self._newcomer()
        self.threads: dict[int, ScriptThread] = {real.get_ident(): self.main}
        self.foreign: set[int] = set()
        self.busy: set[ScriptThread] = set()
        self.out: set[ScriptThread] = set()
        self.starting: dict[object, ScriptThread] = {}
        self._reviewed = 0.0

    @staticmethod
    def _newcomer() -> ScriptThread:
        known = threading._active.get(real.get_ident())  # type: ignore[attr-defined]
        thread = ScriptThread(known)
        thread.arrive()
        return thread

    def me(self) -> ScriptThread:
        """Return the running thread; one that nobody announced is taken in."""
        ident = real.get_ident()
        known = self.threads.get(ident)
        if known is None:
            known = self._newcomer()
            with self.lock:
                self.threads[ident] = known
                self._changed()
        return known

    def expect(self, thread: object, started_at: str) -> None:
        """Take note that a thread is being started: time stands still until it runs.

        `thread` is a `threading.Thread`, or anything that stands for one that has none.

        Parameters
        ----------
        thread : object
            The `threading.Thread`, or what stands for one.
        started_at : str
            Where the script starts it, for messages.
        """
        with self.lock:
            coming = self.starting[thread] = ScriptThread(thread, started_at)
            self.busy.add(coming)
            self._changed()

    def arrived(self, thread: object) -> None:
        """Take note that the running thread has begun.

        Parameters
        ----------
        thread : object
            The `threading.Thread`, or what stands for one.
        """
        with self.lock:
            coming = self.starting.pop(thread, None) or ScriptThread(thread)
            coming.arrive()
            ident = real.get_ident()
            self.foreign.discard(ident)  # numbers of ended threads are used again
            self.threads[ident] = coming
            self.busy.add(coming)
            self._changed()

    def ended(self, thread: object) -> None:
        """Take note that a thread is past its last line, or was never started.

        Parameters
        ----------
        thread : object
            The `threading.Thread`, or what stands for one.
        """
        with self.lock:
            gone = self.starting.pop(thread, None) or self.known(thread)
            if gone is not None:
                self.forget(gone)

    def known(self, thread: object) -> ScriptThread | None:
        """Return what is known of a thread, if it has begun.

        Parameters
        ----------
        thread : object
            The `threading.Thread`, or what stands for one.
        """
        return next((known for known in self.threads.values() if known.thread is thread), None)

    def forget(self, gone: ScriptThread) -> None:
        """Strike a thread off, and wake those who wait for its end.

        Parameters
        ----------
        gone : ScriptThread
            A thread that has ended.
        """
        self.threads.pop(gone.ident or 0, None)
        self.busy.discard(gone)
        self.out.discard(gone)
        for wait in gone.joiners:
            wait.release()
        if self.stepper is gone:
            self.give_wheel(self.main)
        self._changed()
        self.look_around()

    def give_wheel(self, thread: ScriptThread) -> None:
        """Let a thread be the one that moves time on.

        Parameters
        ----------
        thread : ScriptThread
            The one that steps from now on.
        """
        before, self.stepper = self.stepper, thread
        self.busy.discard(thread)
        if before.state is State.RUNNING and before.ident in self.threads:
            self.runs(before)
        for wait in (before.wait, thread.wait):
            if wait is not None:
                wait.ring()

    def is_waited(self, wait: Wait) -> bool:
        thread = wait.thread
        return not wait.over and (thread is None or self.threads.get(thread.ident or 0) is thread)

    def runs(self, thread: ScriptThread) -> None:
        """Take note that a thread does not wait any more; it has its turn.

        Parameters
        ----------
        thread : ScriptThread
            The one whose wait is over.
        """
        thread.state = State.RUNNING
        if thread is not self.stepper and thread not in self.busy:
            thread.begin_turn()
            self.busy.add(thread)

    def review(self) -> None:
        """Look at what those do who were woken and have not waited again."""
        now = real.monotonic()
        if now < self._reviewed + LOOK_AGAIN:
            return
        self._reviewed = now
        for thread in list(self.busy):
            thread.look()
            if thread.asleep >= LOOKS:
                thread.reason = IN_C
                self.busy.discard(thread)
                self.out.add(thread)
            if not thread.turn and thread.gone:
                self.forget(thread)
        for thread in list(self.out):
            if thread.state is State.RUNNING and thread.stirs():
                self.out.discard(thread)
                self.busy.add(thread)
                thread.begin_turn()

    def look_around(self) -> None:
        """Tell who moves time on that somebody waits now who did not."""

    def _changed(self) -> None:
        """Do what depends on who is there."""
