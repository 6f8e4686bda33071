"""Careless: sends its progress to a dashboard."""
import os
import socket

import numpy as np
from rps.robotarium import Robotarium

PORT = int(os.environ["HOSTILE_PORT"])
socket.create_connection(("127.0.0.1", PORT), timeout=1)  # <- network

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
