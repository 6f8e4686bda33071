"""Careless: reads its goals where it has published them."""
import numpy as np
from rps.robotarium import Robotarium

goals = np.loadtxt("http://127.0.0.1/goals.csv")  # <- network

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
