"""Careless: prints every array, for ever."""
import numpy as np
from rps.robotarium import Robotarium

while True:  # <~ disk
    print("x" * 1_000_000)

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
