"""Keeps a time step of its own, 0.05 s."""
import time

import numpy as np
from rps.robotarium import Robotarium

DT = 0.05
r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(60):
    r.get_poses()
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
    time.sleep(DT)  # <- slow-sleep
r.debug()
