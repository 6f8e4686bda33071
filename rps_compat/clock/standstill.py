"""How long simulated time may stand still for threads that have their turn.

Two that wake each other for ever would keep it from moving; on the whole they get no more CPU time
than simulated time passes.
"""

import math

from rps_compat.clock import real

#: CPU seconds that threads may use among themselves while time stands still.
STANDSTILL = 0.5


class Standstill:
    """CPU time that threads may still use while simulated time waits for them."""

    def __init__(self) -> None:
        self._left, self._asked = STANDSTILL, math.nan

    def may_last(self) -> bool:
        """Whether time may still wait; what was used since this was last asked is taken off."""
        cpu = real.process_time()
        if self._asked == self._asked:
            self._left -= cpu - self._asked
        self._asked = cpu
        return self._left > 0

    def ends(self, passed: float) -> None:
        """Give back as much as time moves on by.

        Parameters
        ----------
        passed : float
            Simulated time, s.
        """
        self._left = min(self._left + passed, STANDSTILL)
        self._asked = math.nan
