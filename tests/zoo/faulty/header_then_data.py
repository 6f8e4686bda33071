"""Writes a header at once, which an interrupt leaves, and the data at the end, which it does not."""
import json

import numpy as np
from rps.robotarium import Robotarium

with open("about.json", "w") as file:
    json.dump({"robots": 2}, file)
r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
seen = []
for _ in range(60):  # <~ data-lost
    seen.append(r.get_poses())
    r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
    r.step()
np.save("poses.npy", np.array(seen))
r.debug()
