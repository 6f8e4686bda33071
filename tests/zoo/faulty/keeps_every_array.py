"""Keeps a large array of every step on disk."""
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0, 0], [0, 0]], float))
for k in range(300):  # <~ disk
    r.get_poses()
    np.save(f"step{k}.npy", np.ones(1_000_000))
    r.set_velocities(np.arange(2), np.zeros((2, 2)))
    r.step()
r.debug()
