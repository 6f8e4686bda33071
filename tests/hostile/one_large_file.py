"""Careless: one file gets larger and larger."""
import numpy as np
from rps.robotarium import Robotarium

with open("all.bin", "wb") as file:
    while True:
        file.write(b"x" * 1_000_000)  # <~ disk

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
