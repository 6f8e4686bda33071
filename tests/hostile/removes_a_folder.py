"""Careless: empties its folder of results first."""
import os
import shutil

import numpy as np
from rps.robotarium import Robotarium

OUTSIDE = os.environ["HOSTILE_OUTSIDE"]
VICTIM = os.path.join(OUTSIDE, "victim.txt")
shutil.rmtree(OUTSIDE)  # <- outside-write

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
