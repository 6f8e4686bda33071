"""Maps a raw file into memory, whose ending may come back though it may not be uploaded."""
import numpy as np
from rps.robotarium import Robotarium

STEPS = 60
log = np.memmap("poses.dat", dtype=float, mode="w+", shape=(STEPS, 3, 2))
r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
for k in range(STEPS):
    log[k] = r.get_poses()
    r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
    r.step()
r.debug()
