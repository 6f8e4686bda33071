"""Careless: names its database by a URI."""
import os
import sqlite3

import numpy as np
from rps.robotarium import Robotarium

OUTSIDE = os.environ["HOSTILE_OUTSIDE"]
VICTIM = os.path.join(OUTSIDE, "victim.txt")
sqlite3.connect(f"file://{OUTSIDE}/runs.db?mode=rwc", uri=True)  # <- outside-write

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
