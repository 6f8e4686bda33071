"""Saves in the ``else`` of the loop, which an interrupted loop does not reach."""
import json

import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
seen = []
for _ in range(60):
    seen.append(r.get_poses().tolist())
    r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
    r.step()
else:
    with open("poses.json", "w") as file:  # <- save-at-end
        json.dump(seen, file)
r.debug()
