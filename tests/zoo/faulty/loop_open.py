"""Reads the files of its paths by names built in a loop; they are not there."""
import numpy as np
from rps.robotarium import Robotarium

paths = [np.load(f"path_{i}.npy") for i in range(2)]  # <- file-missing
r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
for _ in range(60):
    r.get_poses()
    r.set_velocities(np.arange(2), np.zeros((2, 2)))
    r.step()
r.debug()
