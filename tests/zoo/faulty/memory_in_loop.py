"""Keeps a large array of every step."""
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
kept = []
for _ in range(300):
    r.get_poses()
    r.set_velocities([0], np.zeros((2, 1)))
    kept.append(np.ones((2000, 2000)))  # <- memory
    r.step()
r.debug()
