"""Writes each step into a memory-mapped file."""
import numpy as np
from rps.robotarium import Robotarium

STEPS = 90
log = np.lib.format.open_memmap("poses.npy", mode="w+", dtype=float, shape=(STEPS, 3, 2))
r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
for k in range(STEPS):
    log[k] = r.get_poses()
    r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.1, -0.1]]))
    r.step()
r.debug()
