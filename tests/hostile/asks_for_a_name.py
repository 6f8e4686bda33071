"""Careless: looks where it is."""
import socket

import numpy as np
from rps.robotarium import Robotarium

socket.getaddrinfo("localhost", 80)  # <- network

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
