"""Careless: uses a temporary file, for which no place is told."""
import tempfile

import numpy as np
from rps.robotarium import Robotarium

tempfile.NamedTemporaryFile()  # <- outside-write

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
