"""Runs off the end of a list in its last third."""
import numpy as np
from rps.robotarium import Robotarium

speeds = [0.05] * 40
r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
for k in range(60):
    r.get_poses()
    r.set_velocities([0], np.array([[speeds[k]], [0.0]]))  # <- crash
    r.step()
r.debug()
