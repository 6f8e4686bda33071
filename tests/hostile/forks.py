"""Careless: lets a child write its log."""
import os
import time

import numpy as np
from rps.robotarium import Robotarium

if os.fork() == 0:  # <- fork
    time.sleep(1000)

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
