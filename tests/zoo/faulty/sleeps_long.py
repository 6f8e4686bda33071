"""Waits 0.8 s at one step, in which the robots brake."""
from time import sleep

import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for k in range(60):
    r.get_poses()
    if k == 20:
        sleep(0.8)  # <- watchdog
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
r.debug()
