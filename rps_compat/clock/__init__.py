"""Time that does not wait: the script's clock during a headless run.

A script that paces itself, ``time.sleep(0.033)``, ``while time.time() - start < 60``, means the
time of the experiment. While a :class:`SimulatedClock` is in force, that is the time it gets:
steps and waits move it on, and neither takes any. Each look at the clock moves it on by a
microsecond, so that a loop that waits by looking comes to an end, after the same number of looks in
every run.

A script has more than one way to wait, and may have more than one thread. `scheduler` says how
simulated time moves where there are several, `stand_ins` lists what waits in it, and `outside` what
keeps the real time: other processes, sockets. With one thread nothing is scheduled: a look or a
sleep is an addition.

Libraries that freeze time for tests do less and cost a dependency: freezegun replaces the
functions that read a clock, time-machine does so faster, in C. Neither makes anybody wait in its
time: threads, queues and event loops would still sleep by the real one.
"""

from rps_compat.clock.simulated import LOOK, SimulatedClock
from rps_compat.clock.stuck import Stuck

__all__ = ["LOOK", "SimulatedClock", "Stuck"]
