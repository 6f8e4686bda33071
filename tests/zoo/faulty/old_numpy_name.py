"""A name that numpy 2 has no more."""
import numpy as np
from rps.robotarium import Robotarium
speed = np.float_(0.05)  # <- removed-from-numpy

r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
for _ in range(60):
    r.get_poses()
    r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
    r.step()
r.debug()
