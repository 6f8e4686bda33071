"""Writes by the C library."""
import ctypes
import os

import numpy as np
from rps.robotarium import Robotarium

OUTSIDE = os.environ["HOSTILE_OUTSIDE"]
VICTIM = os.path.join(OUTSIDE, "victim.txt")
libc = ctypes.CDLL(None)
descriptor = libc.open(os.path.join(OUTSIDE, "native.txt").encode(), os.O_WRONLY | os.O_CREAT, 0o600)
libc.write(descriptor, b"native", 6)

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
