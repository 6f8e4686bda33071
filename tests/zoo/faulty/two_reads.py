"""Reads poses twice in a step, which the API forbids."""
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
for k in range(60):
    x = r.get_poses()
    theta = r.get_poses()[2]  # <- crash
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
r.debug()
