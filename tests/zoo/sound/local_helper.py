"""Imports a module that lies beside it."""
import numpy as np
from rps.robotarium import Robotarium
from zoo_helper import spin

r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
for _ in range(60):
    r.get_poses()
    r.set_velocities(np.arange(2), spin(2))
    r.step()
r.debug()
