"""Writes by the HDF5 library."""
import os

import numpy as np
from rps.robotarium import Robotarium

OUTSIDE = os.environ["HOSTILE_OUTSIDE"]
VICTIM = os.path.join(OUTSIDE, "victim.txt")
import h5py

h5py.File(os.path.join(OUTSIDE, "native.txt"), "w").close()

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
