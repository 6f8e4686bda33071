"""Connects by the C library."""
import ctypes
import os
import struct

import numpy as np
from rps.robotarium import Robotarium

PORT = int(os.environ["HOSTILE_PORT"])
libc = ctypes.CDLL(None)
address = struct.pack("=HH4s8x", 2, PORT >> 8 | (PORT & 255) << 8, bytes([127, 0, 0, 1]))
libc.connect(libc.socket(2, 1, 0), address, len(address))

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
