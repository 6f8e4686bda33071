"""Careless: fetches its parameters."""
import os
import urllib.request

import numpy as np
from rps.robotarium import Robotarium

PORT = int(os.environ["HOSTILE_PORT"])
urllib.request.urlopen(f"http://127.0.0.1:{PORT}/gains.json", timeout=1)  # <- network

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
