"""Saves in the home folder, after the loop."""
import os

import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
seen = []
for _ in range(60):
    seen.append(r.get_poses())
    r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
    r.step()
r.debug()
np.save(os.path.expanduser("~/posflock-zoo.npy"), np.array(seen))  # <- outside-write
