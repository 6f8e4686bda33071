"""Ends by the clock, not by a number of steps."""
import time

import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
start = time.time()
while time.time() - start < 5.0:
    r.get_poses()
    r.set_velocities([0], np.array([[0.02], [0.3]]))
    r.step()
r.debug()
