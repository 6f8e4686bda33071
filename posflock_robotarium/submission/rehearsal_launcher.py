"""Drives the uploaded ``main.py`` in the environment of `posflock_robotarium.submission.rehearse`.

Runs there, not here: it imports nothing of this package, and the simulator under a private name.
"""

import importlib
import json
import sys


def main() -> None:
    """Obey the order that is given as the one argument, and leave the outcome where it says."""
    with open(sys.argv[1]) as file:
        order = json.load(file)
    sys.path.append(order["simulator"])
    running = f"{order['package']}.running"
    plan = importlib.import_module(f"{running}.plan").RunPlan.from_dict(order["plan"])
    outcome = importlib.import_module(f"{running}.driver").drive(plan)
    with open(order["outcome"], "w") as file:
        json.dump(outcome.as_dict(), file)


if __name__ == "__main__":
    main()
