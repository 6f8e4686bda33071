"""Its history grows until a step takes too long: at the end, not at the median."""
import time

import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
history = []
for _ in range(90):  # <~ slow-loop
    history.append(r.get_poses())
    time.sleep(0.0005 * len(history))
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
r.debug()
