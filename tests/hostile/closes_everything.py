"""Hostile: closes every descriptor, so that nothing can be told of it."""
import os

import numpy as np
from rps.robotarium import Robotarium

os.closerange(3, 256)  # <~ crash

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
