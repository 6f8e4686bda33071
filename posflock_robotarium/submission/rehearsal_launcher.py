"""Drives the uploaded ``main.py`` in the environment of `posflock_robotarium.submission.rehearse`.

Runs there, not here: it imports nothing of this package, and the simulator under a private name.
"""

import importlib
import json
import os
import sys


def main() -> None:
    """Obey the order on the standard input, and tell the outcome through the pipe that it names."""
    order = json.load(sys.stdin)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    sys.path.append(order["simulator"])
    running = f"{order['package']}.running"
    plan = importlib.import_module(f"{running}.plan").RunPlan.from_dict(order["plan"])
    teller = importlib.import_module(f"{running}.watching").Teller(order["pipe"], order["word"])
    driver = importlib.import_module(f"{running}.driver")
    teller.outcome(driver.drive(plan, driver.Guests(teller=teller)))


if __name__ == "__main__":
    main()
