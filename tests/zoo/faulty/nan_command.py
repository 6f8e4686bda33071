"""Divides by zero at t = 1 s."""
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
for k in range(60):
    r.get_poses()
    with np.errstate(all="ignore"):
        v = np.float64(0.0) / (30 - k if k < 31 else 1)
    r.set_velocities([0], np.array([[v], [0.0]]))  # <- crash
    r.step()
r.debug()
