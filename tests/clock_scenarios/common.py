"""What every scenario has: its clock, steps, threads, and what it is called."""

import threading
import time
from types import SimpleNamespace

from rps_compat.clock import SimulatedClock

#: Functions by their names; each returns what JSON can hold.
SCENARIOS = {}
#: The clock in force.
now = SimpleNamespace(clock=SimulatedClock())


def scenario(function):
    SCENARIOS[function.__name__] = function
    return function


def step(seconds=0.1):
    now.clock.advance(seconds)


def since(start):
    return round(time.monotonic() - start, 3)


def started(function, *arguments, daemon=False):
    thread = threading.Thread(target=function, args=arguments, daemon=daemon)
    thread.start()
    return thread
