"""Allocates until nothing is left."""
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
kept = []
for k in range(100):
    r.get_poses()
    kept.append(np.ones((1 << 25, 8)))  # <- memory
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
r.debug()
