"""Careless: keeps a file a step, each of some size, and never ends that."""
import numpy as np
from rps.robotarium import Robotarium

k = 0
while True:  # <~ disk
    k += 1
    np.save(f"step{k}.npy", np.ones(1_000_000))

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
