"""Saves whatever happens."""
import numpy as np
from rps.robotarium import Robotarium

seen = []
r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
try:
    for k in range(90):
        seen.append(r.get_poses())
        r.set_velocities([0], np.array([[0.05], [0.5]]))
        r.step()
finally:
    np.save("poses.npy", np.array(seen))
r.debug()
