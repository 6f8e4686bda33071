"""What threads, queues, event loops and timers see of simulated time; run by test_clock.py.

``python tests/clock_scenarios [--repeat N] [NAME ...]`` prints one JSON list a scenario, ``[name,
what it returned]``; with ``--list`` the names alone. Each runs under a clock of its own; one that
hangs ends the process, and a traceback on stderr says where. Time does not depend on the machine's
load, so neither do results: repeat them by the hundred on a busy machine.
"""

import argparse
import faulthandler
import importlib
import json
import os

from common import SCENARIOS, now

from rps_compat.clock import SimulatedClock, real
from rps_compat.clock.stand_ins import in_force

HANGS = 60
for part in ("single", "several", "loops", "beyond"):
    importlib.import_module(part)


def watch(name, done):
    """End the process where a scenario hangs; works in forked processes, too."""
    if not done.acquire(True, HANGS):
        print(f"{name} hangs", flush=True)
        faulthandler.dump_traceback()
        os._exit(1)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=1)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("names", nargs="*")
    asked = parser.parse_args()
    if asked.list:
        print(*SCENARIOS, flush=True)
        return
    for name in asked.names or SCENARIOS:
        for _ in range(asked.repeat):
            done = real.allocate_lock()
            done.acquire()
            real.start_new_thread(watch, (name, done))
            now.clock = SimulatedClock(longest_wait=900)
            with in_force(now.clock):
                result = SCENARIOS[name]()
            done.release()
            print(json.dumps([name, result]), flush=True)


if __name__ == "__main__":
    main()
    os._exit(0)  # some threads wait for ever, which is what they are for
