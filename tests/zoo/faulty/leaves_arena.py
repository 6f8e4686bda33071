"""Drives through the wall, at 1.6 m after 6 s."""
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.array([[1.0], [0.0], [0.0]]))
for _ in range(300):  # <~ boundary 6.0
    r.get_poses()
    r.set_velocities([0], np.array([[0.1], [0.0]]))
    r.step()
r.debug()
