"""Careless: saves one folder up."""
import numpy as np
from rps.robotarium import Robotarium

np.savetxt("../poses.txt", np.zeros((2, 2)))  # <- outside-write

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
