"""Ends another process by the C library."""
import ctypes
import os

import numpy as np
from rps.robotarium import Robotarium

ctypes.CDLL(None).kill(int(os.environ["HOSTILE_PROCESS"]), 9)

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
