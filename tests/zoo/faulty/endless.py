"""Waits for a robot to be at a place that it never reaches."""
# declared: 30
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
while r.get_poses()[0, 0] < 1.0:  # <~ endless
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
r.debug()
