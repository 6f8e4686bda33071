"""Threads that wait in simulated time: a small discrete-event scheduler.

Simulated time belongs to the thread that makes the steps, the *stepper*; at first that is the main
thread. It moves in three ways:

1.  The stepper steps. Time moves on by the step, through the deadlines of all who wait meanwhile.
    Each is woken at its own time, one after the other, and has its turn: time stands still until
    it waits again.
2.  The stepper waits, and so does everybody else: time jumps to the earliest deadline.
3.  Somebody computes for longer than his turn. Then neither a step nor a wait outruns the real
    time, as it could not on the testbed. Nor does a wait while somebody waits for another process
    or a socket, whose time is real.

The stepper moves time on itself, inside its own waits and steps. Where it hangs in a wait that the
scheduler was not told of, or neither steps nor waits for long, a ticking thread does so in its
place, in real time: whoever sleeps must wake.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator

from rps_compat.clock import real
from rps_compat.clock.deadlines import Deadlines
from rps_compat.clock.roster import LOOK_AGAIN, Roster
from rps_compat.clock.standstill import Standstill
from rps_compat.clock.stuck import Stuck
from rps_compat.clock.threads import ScriptThread, State
from rps_compat.clock.waits import Wait

#: Waits shorter than this many seconds take as long if a thread makes more than some in a row.
SHORTEST, SOME = 1e-4, 10
#: Real seconds that all must have waited for ever: something that Python does not see may come.
PATIENCE = 1.0


class Scheduler(Roster):
    """Simulated time and those who wait in it.

    Parameters
    ----------
    longest_wait
        Simulated seconds without a step after which whoever waits is told that it is for ever.

    Attributes
    ----------
    elapsed : float
        Simulated seconds.
    over : bool
        Whether the clock is no longer in force: waits end in real time.
    moves : int
        How often the stepper has stepped or waited.
    stepped : float
        When the last step ended.
    real_reasons : dict
        Why simulated time went with the real time; the keys are words for people.
    """

    def __init__(self, longest_wait: float = math.inf) -> None:
        self.elapsed = 0.0
        self.over = False
        self.moves = 0
        self.real_reasons: dict[str, None] = {}
        self.longest_wait = longest_wait
        self.stepped = 0.0
        self._begin()

    def _begin(self) -> None:
        """Know of nobody but the running thread, and of no wait."""
        super()._begin()
        self._polled: list[Wait] = []
        self.alarm: Wait | None = None
        self._deadlines = Deadlines()
        self._leash: tuple[float, float] | None = None
        self._silent_since: float | None = None
        self._standstill = Standstill()

    # --- Waiting --------------------------------------------------------------------------------

    def wait(self, timeout: float | None, wait: Wait | None = None) -> bool:
        """Wait in simulated time; return whether somebody woke the thread before the deadline.

        Parameters
        ----------
        timeout
            Simulated seconds; None waits until woken.
        wait
            The wait that others know of; by default nobody does.

        Raises
        ------
        Stuck
            Nothing will ever wake the thread.
        """
        me, wait = self.me(), wait or Wait(self)
        outer = me.wait
        try:
            with self.lock:
                if wait.over:
                    return wait.woken
                wait.thread = me
                me.wait, me.state = wait, State.WAITING
                self.busy.discard(me)
                self.out.discard(me)
                self.moves += self.stepper is me and timeout != 0
                if timeout is not None:
                    self.schedule(wait, self._long_enough(me, timeout))
                if wait.polled:
                    self._polled.append(wait)
                self.look_around()
            while not wait.over and not self.over:
                if self.stepper is me:
                    self._move_time(wait)
                else:
                    wait.block()
            self._wait_on(wait)
        finally:
            with self.lock:
                wait.expired = not wait.woken  # whoever comes now comes too late
                me.wait = outer
                if outer is None:
                    self.runs(me)
                else:
                    me.state = State.WAITING
                if wait in self._polled:
                    self._polled.remove(wait)
                self._changed()
        if wait.failure is not None:
            raise wait.failure
        return wait.woken

    def _long_enough(self, thread: ScriptThread, timeout: float) -> float:
        """Let no thread but the stepper wait for next to no time again and again."""
        thread.short_waits = thread.short_waits + 1 if timeout < SHORTEST else 0
        if thread is self.stepper or thread.short_waits <= SOME:
            return timeout
        return SHORTEST

    def _wait_on(self, wait: Wait) -> None:
        """Wait on in real time, since the clock is no longer in force."""
        end = real.monotonic() + wait.deadline - self.elapsed
        while not wait.over:
            left = end - real.monotonic()
            if left <= 0:
                return
            wait.block(left)

    def wait_for_end(self, thread: object) -> Wait | None:
        """Return a wait that is over when a thread has ended; None if nothing is known of it.

        Parameters
        ----------
        thread : object
            The `threading.Thread`, or what stands for one.
        """
        with self.lock:
            known = self.starting.get(thread) or self.known(thread)
            if known is None:
                return None
            wait = Wait(self)
            known.joiners.append(wait)
            return wait

    def schedule(self, wait: Wait, seconds: float) -> None:
        """Give a wait a deadline, if nothing ends it before.

        Parameters
        ----------
        wait : Wait
            What a thread waits in, or an alarm.
        seconds : float
            Simulated time from now, s.
        """
        with self.lock:
            wait.deadline = self.elapsed + max(seconds, 0.0)
            self._deadlines.add(wait)
            self._changed()

    def wake(self, wait: Wait) -> None:
        with self.lock:
            if not wait.over:
                wait.woken = True
                self.woken(wait)

    def woken(self, wait: Wait) -> None:
        if wait.thread is not None and wait.thread.wait is wait:
            self.runs(wait.thread)
        self._silent_since = None
        wait.ring()

    @contextlib.contextmanager
    def outside(self, reason: str) -> Iterator[None]:
        """Wait for the world outside within the ``with`` block: its time is real.

        Parameters
        ----------
        reason
            For whom, in words for people.
        """
        me = self.me()
        if me.state is State.OUTSIDE:
            yield
            return
        with self.lock:
            me.state, me.since, me.reason = State.OUTSIDE, real.monotonic(), reason
            self.busy.discard(me)
            self.out.add(me)
            self.look_around()
        try:
            yield
        finally:
            with self.lock:
                self.out.discard(me)
                self.runs(me)
                if self.stepper is me:
                    passed = real.monotonic() - me.since
                    self._pass(passed, reason)
            if self.stepper is me and self._deadlines:
                self.move_to(self.elapsed)

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """Stay within a step for as long as the ``with`` block takes: its real time is nobody's.

        Who looks on may hold the script in a step; others wait meanwhile, and nobody takes the
        thread that steps for one that hangs or computes.
        """
        me = self.me()
        with self.lock:
            if self.stepper is not me:
                self.give_wheel(me)
            before, me.state = me.state, State.WAITING
        try:
            yield
        finally:
            with self.lock:
                me.state, self._leash = before, None

    # --- Moving time ----------------------------------------------------------------------------

    def move_to(self, target: float) -> None:
        """Let the running thread, which steps, move time on.

        Parameters
        ----------
        target : float
            Simulated time to reach, s since the start.
        """
        me = self.me()
        with self.lock:
            if self.stepper is not me:
                self.give_wheel(me)
            alone = not (self.busy or self.out or self._polled or me.asks)
            if self.over or (alone and self.next_deadline() > target):
                self._move(target)
                return
        wait = Wait(self)
        outer, me.engine = me.engine, wait
        try:
            while True:
                with self.lock:
                    pause = self._turn(target, asks=me.asks)
                if pause is None:
                    return
                if pause:
                    wait.block(pause)
        finally:
            me.engine, me.asks = outer, False

    def _move_time(self, wait: Wait) -> None:
        """Move time on until `wait`, of the stepper, is over, or another thread steps."""
        me = self.stepper
        outer, me.engine = me.engine, wait
        try:
            while True:
                with self.lock:
                    if wait.over or self.over or self.stepper is not me:
                        return
                    pause = self._turn(wait.deadline, asks=True)
                if pause:
                    wait.block(pause)
        finally:
            me.engine, me.asks = outer, False

    def look_around(self) -> None:
        """Tell who moves time on that somebody waits now who did not."""
        if self.stepper.engine is not None and not any(thread.turn for thread in self.busy):
            self.stepper.engine.ring()

    def _turn(self, target: float, asks: bool) -> float | None:
        """Move time on if nobody needs more of it.

        Parameters
        ----------
        target
            How far time may go, simulated seconds.
        asks
            Whether those who wait for the world outside hold it to the real time.

        Returns
        -------
        float or None
            Real seconds to block for before the next turn; None at the target.
        """
        goal = min(self.next_deadline(), target)
        if self.busy or self.out:
            self.review()
            if any(thread.turn for thread in self.busy) and self._standstill.may_last():
                return LOOK_AGAIN
        if goal > self.elapsed:
            if self._ready():
                return LOOK_AGAIN
            if self.busy or (asks and (self.out or self.stepper.asks)):
                self._go_with_real_time(goal)
                if self.elapsed < goal:
                    self._note_who_holds_time()
                    return min(LOOK_AGAIN, goal - self.elapsed)
            else:
                self._leash = None
        if math.isinf(goal):
            return self._nobody_will_wake_anybody()
        self._silent_since = None
        self._move(goal)
        if not self.fire_next():
            return None
        self.check_length()
        return 0.0

    def _move(self, time: float) -> None:
        """Move time to `time`, if that lies ahead."""
        if time > self.elapsed:
            self._standstill.ends(time - self.elapsed)
            self.elapsed = time

    def next_deadline(self) -> float:
        """When the next wait ends; infinity where none does."""
        return self._deadlines.earliest()

    def fire_next(self) -> bool:
        """End the first wait whose deadline has come; return whether there was one."""
        if self.next_deadline() > self.elapsed:
            return False
        self._deadlines.take().fire()
        return True

    def _ready(self) -> bool:
        """Wake those whose descriptors are ready; return whether there are any."""
        ready = [wait for wait in self._polled if not wait.over and wait.ready()]
        for wait in ready:
            self.wake(wait)
        return bool(ready)

    def _go_with_real_time(self, goal: float) -> None:
        """Move time towards `goal`, no farther than real time went since the last such move."""
        now = real.monotonic()
        if self._leash is None:
            self._leash = (self.elapsed, now)
        time, then = self._leash
        self._move(min(goal, time + now - then))
        if self.elapsed >= goal:
            self._leash = (self.elapsed, now)

    def _note_who_holds_time(self) -> None:
        holding = ["threads that compute"] if self.busy else [t.reason for t in self.out]
        for reason in holding or [self.stepper.reason]:
            self.real_reasons[reason] = None

    def _pass(self, seconds: float, reason: str) -> None:
        """Let real `seconds` pass in simulated time, too."""
        self.elapsed += seconds
        if seconds > LOOK_AGAIN:
            self.real_reasons[reason] = None

    # --- Waiting for ever -----------------------------------------------------------------------

    def _nobody_will_wake_anybody(self) -> float:
        """Wait a while all the same, then say so in the main thread."""
        now = real.monotonic()
        if self._silent_since is None:
            self._silent_since = now
        if now - self._silent_since < PATIENCE:
            return 0.05
        self._fail(Stuck.told_of(self.threads.values()))
        return 0.05

    def check_length(self) -> None:
        """Tell the script that it waits for ever, if nobody has stepped for too long."""
        if self.elapsed - self.stepped > self.longest_wait:
            waiting = [thread for thread in self.threads.values() if thread.wait is not None]
            self._fail(Stuck.told_of(waiting or [self.main], self.longest_wait))

    def _fail(self, stuck: Stuck) -> None:
        """Raise Stuck in the main thread, where it waits, or else in the running one."""
        wait = self.main.wait
        if self.stepper is self.main or wait is None:
            raise stuck
        wait.failure = stuck
        wait.fire()
