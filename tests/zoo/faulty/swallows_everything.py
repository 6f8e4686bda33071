"""Loses its data to an interrupt, in a way that the source does not show."""
import atexit

import numpy as np
from rps.robotarium import Robotarium

seen = []
done = []
atexit.register(lambda: done and np.save("poses.npy", np.array(seen)))
r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
for k in range(60):  # <~ data-lost
    seen.append(r.get_poses())
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
done.append(True)
r.debug()
