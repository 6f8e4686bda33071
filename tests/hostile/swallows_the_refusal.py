"""Hostile: tries again and again, and hides every refusal."""
import contextlib
import os

import numpy as np
from rps.robotarium import Robotarium

OUTSIDE = os.environ["HOSTILE_OUTSIDE"]
VICTIM = os.path.join(OUTSIDE, "victim.txt")
for _ in range(10_000):
    with contextlib.suppress(Exception):
        open(VICTIM, "w")  # <- outside-write

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
