"""Careless: computes in four processes."""
import multiprocessing

import numpy as np
from rps.robotarium import Robotarium

with multiprocessing.get_context("fork").Pool(4) as pool:  # <- fork
    pool.map(abs, [1, -1])

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
