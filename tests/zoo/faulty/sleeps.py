"""Keeps its own time in the loop."""
import time

import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
for k in range(60):
    r.get_poses()
    if k % 20 == 0:
        time.sleep(0.1)  # <- slow-sleep
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
r.debug()
