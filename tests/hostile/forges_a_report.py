"""Hostile: writes the report that it would like to have."""
import numpy as np
from rps.robotarium import Robotarium

open("../outcome.json", "w").write('{"ended": "finished"}')  # <- outside-write

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
