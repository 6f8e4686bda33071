"""Time that does not wait: the script's clock during a headless run.

A script that paces itself, ``time.sleep(0.033)``, ``while time.time() - start < 60``, means the
time of the experiment. While a :class:`SimulatedClock` is in force, that is the time it gets:
steps and sleeps advance it, and neither takes any. Each look at the clock advances it by a
microsecond, so that a loop that waits by looking comes to an end, after the same number of looks in
every run.
"""

import contextlib
import time
from collections.abc import Iterator

LOOK = 1e-6


class SimulatedClock:
    """Seconds since the start of a run, advanced by steps and sleeps.

    Parameters
    ----------
    start
        What ``time.time()`` reads at the start, seconds since 1970. By default the real time.
    """

    def __init__(self, start: float | None = None) -> None:
        self.elapsed = 0.0
        self._epoch = time.time() if start is None else start
        self._monotonic = time.monotonic()

    def advance(self, seconds: float) -> None:
        """Let `seconds` pass; negative times do not."""
        self.elapsed += max(float(seconds), 0.0)

    def time(self) -> float:
        """Stand in for ``time.time``."""
        self.elapsed += LOOK
        return self._epoch + self.elapsed

    def monotonic(self) -> float:
        """Stand in for ``time.monotonic`` and ``time.perf_counter``."""
        self.elapsed += LOOK
        return self._monotonic + self.elapsed

    @contextlib.contextmanager
    def in_force(self) -> Iterator["SimulatedClock"]:
        """Make this the clock of the ``time`` module within the ``with`` block."""
        ours = {
            "time": self.time,
            "monotonic": self.monotonic,
            "perf_counter": self.monotonic,
            "sleep": self.advance,
        }
        before = {name: getattr(time, name) for name in ours}
        for name, function in ours.items():
            setattr(time, name, function)
        try:
            yield self
        finally:
            for name, function in before.items():
                setattr(time, name, function)
