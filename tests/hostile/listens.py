"""Careless: waits for a joystick."""
import socket

import numpy as np
from rps.robotarium import Robotarium

socket.create_server(("127.0.0.1", 0))  # <- network

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
