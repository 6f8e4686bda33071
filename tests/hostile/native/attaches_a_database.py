"""Lets SQL open a file."""
import os
import sqlite3

import numpy as np
from rps.robotarium import Robotarium

OUTSIDE = os.environ["HOSTILE_OUTSIDE"]
VICTIM = os.path.join(OUTSIDE, "victim.txt")
with sqlite3.connect(":memory:") as database:
    database.execute("ATTACH ? AS other", [os.path.join(OUTSIDE, "native.txt")])
    database.execute("CREATE TABLE other.poses (x)")

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
