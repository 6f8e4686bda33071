"""Careless: lists its files."""
import os

import numpy as np
from rps.robotarium import Robotarium

os.system("ls")  # <- fork

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
