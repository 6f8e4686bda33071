"""One way to run a script, and one account of how it went.

``run``, ``verify`` and ``rehearse`` run scripts for different ends: to have their log, to find
their faults, to see them in the testbed's environment. What they do to a script is the same, and
differs by the fields of one `RunPlan`: ``driver.drive`` obeys it in the process that it is called
in, and returns an `Outcome`. Both are plain data, so that the process may be another than the one
that asks.

Needs numpy alone, and matplotlib only for a script that draws.
"""

__all__ = ["outcome", "plan", "policy_violations"]
