"""Computes for more than a time step in each loop."""
import time

import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
pause = float("0.06")  # what cannot be read off the source
for k in range(60):  # <~ slow-loop
    r.get_poses()
    time.sleep(pause)
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
r.debug()
