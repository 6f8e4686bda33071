"""Careless: sends poses to a plotter, by UDP."""
import os
import socket

import numpy as np
from rps.robotarium import Robotarium

PORT = int(os.environ["HOSTILE_PORT"])
socket.socket(type=socket.SOCK_DGRAM).sendto(b"poses", ("127.0.0.1", PORT))  # <- network

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
