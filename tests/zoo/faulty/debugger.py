"""A debugger was left in."""
import pdb

import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(60):
    r.get_poses()
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
pdb.set_trace()  # <- blocking-call
r.debug()
