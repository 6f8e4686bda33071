"""Starts a process of another session by the C library."""
import ctypes
import os
import time

import numpy as np
from rps.robotarium import Robotarium

if ctypes.CDLL(None).fork() == 0:
    os.setsid()
    time.sleep(1000)

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
