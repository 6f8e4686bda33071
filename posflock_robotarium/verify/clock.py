"""The time of day that a script sees during a trial.

Nothing is drawn and nobody waits, so that a trial takes seconds; the clock advances as the
testbed's would, by the longer of a time step and what the script computed (CPU time of this
machine) or slept.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator

#: Real functions, before a clock replaces them.
cpu_seconds, wall_time = time.process_time, time.time


class Clock:
    """The testbed's time of day for a script that does not wait.

    Between two steps pass the longer of 33 ms and what the script spent.
    """

    def __init__(self) -> None:
        self.start = wall_time()
        self.now = 0.0
        self._slept = 0.0
        self._cpu = cpu_seconds()

    def spent(self) -> float:
        """Seconds that the script computed and slept since the last step."""
        return cpu_seconds() - self._cpu + self._slept

    def read(self) -> float:
        """Seconds since the start."""
        return self.now + self.spent()

    def sleep(self, seconds: float) -> None:
        """Let time pass, without waiting."""
        if seconds < 0:
            raise ValueError("sleep length must be non-negative")
        self._slept += seconds

    def step(self, time_step: float) -> None:
        """End a time step."""
        self.now += max(time_step, self.spent())
        self.resume()

    def resume(self) -> None:
        """Start counting the script's own time again."""
        self._cpu, self._slept = cpu_seconds(), 0.0

    @contextlib.contextmanager
    def installed(self) -> Iterator[None]:
        """Let the module `time` tell this clock's time."""
        before = {name: getattr(time, name) for name in ("time", "monotonic", "perf_counter")}
        sleep = time.sleep
        time.time = lambda: self.start + self.read()
        time.monotonic = time.perf_counter = self.read
        time.sleep = self.sleep  # type: ignore[assignment]
        try:
            yield
        finally:
            for name, function in before.items():
                setattr(time, name, function)
            time.sleep = sleep
