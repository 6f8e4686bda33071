"""Careless: keeps everything in memory."""
import numpy as np
from rps.robotarium import Robotarium

kept = []
while True:
    kept.append(np.ones(10_000_000))  # <- memory

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
