"""Careless: the same, and the address is put together."""
import os

import numpy as np
from rps.robotarium import Robotarium

PORT = int(os.environ["HOSTILE_PORT"])
goals = np.loadtxt("/".join(["http:", "", f"127.0.0.1:{PORT}", "goals.csv"]))  # <- network

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
