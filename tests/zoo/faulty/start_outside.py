"""Starts outside the arena by a typing error."""
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.array([[-1.7], [0.0], [0.0]]))  # <~ boundary 0.0
for _ in range(100):
    r.get_poses()
    r.set_velocities([0], np.array([[0.1], [0.0]]))
    r.step()
r.debug()
