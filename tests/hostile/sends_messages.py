"""Careless: the same, by sendmsg."""
import os
import socket

import numpy as np
from rps.robotarium import Robotarium

PORT = int(os.environ["HOSTILE_PORT"])
plotter = socket.socket(type=socket.SOCK_DGRAM)
plotter.sendmsg([b"poses"], [], 0, ("127.0.0.1", PORT))  # <- network

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
