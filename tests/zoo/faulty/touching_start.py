"""Starts with two robots 10 cm apart, which is a collision already."""
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=2, initial_conditions=np.array([[0.0, 0.1], [0.0, 0.0], [np.pi, 0.0]]))
for _ in range(60):  # <~ close-start 0.0
    r.get_poses()
    r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
    r.step()
r.debug()
