"""Stops at t = 1 s to plan for a second: the robots brake."""
import time

import numpy as np
from rps.robotarium import Robotarium

seconds = {30: float("1.0")}
r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
for k in range(60):  # <~ watchdog 1.0
    r.get_poses()
    time.sleep(seconds.get(k, 0.0))
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
r.debug()
