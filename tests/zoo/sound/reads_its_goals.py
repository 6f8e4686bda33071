"""Reads a file that lies beside it."""
import numpy as np
from rps.robotarium import Robotarium

goals = np.load("goal_points.npy")
r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
for _ in range(90):
    x = r.get_poses()
    ahead = np.sign(goals[0] - x[0]) * 0.05
    r.set_velocities(np.arange(2), np.array([ahead, [0.0, 0.0]]))
    r.step()
r.debug()
