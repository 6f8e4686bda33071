"""Waits in the order in which simulated time ends them."""

from __future__ import annotations

import heapq
import math
from itertools import count

from rps_compat.clock.waits import Wait


class Deadlines:
    """Waits by their deadlines, the earliest first; of equal ones, the one that was added first.

    A wait that is over before its deadline stays until its turn comes.
    """

    def __init__(self) -> None:
        self._queue: list[tuple[float, int, Wait]] = []
        self._order = count()

    def __bool__(self) -> bool:
        return bool(self._queue)

    def add(self, wait: Wait) -> None:
        """Let a wait end at its deadline.

        Parameters
        ----------
        wait : Wait
            Its deadline, simulated seconds, is set already.
        """
        heapq.heappush(self._queue, (wait.deadline, next(self._order), wait))

    def earliest(self) -> float:
        """Return the first deadline of a wait that is not over, simulated seconds; or infinity."""
        queue = self._queue
        while queue and queue[0][2].over:
            heapq.heappop(queue)
        return queue[0][0] if queue else math.inf

    def take(self) -> Wait:
        """Take out the wait that `earliest` has told of."""
        return heapq.heappop(self._queue)[2]
