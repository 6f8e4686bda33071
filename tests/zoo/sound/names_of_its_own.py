"""Own functions and methods that are called like the API's of either generation."""
import numpy as np
from rps.robotarium import *
from rps.utilities.misc import *
from rps.utilities.controllers import *


def at_position(x, goal):
    return np.linalg.norm(x[:2] - goal, axis=0) < 0.1


class Drawing:
    time_step = 0.1
    boundaries = (0, 1)

    def show(self):
        return self.time_step

    def step(self):
        return None

    def input(self):
        return 3


d = Drawing()
d.show(); d.step(); d.input()
r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))

for _ in range(60):
    x = r.get_poses()
    at_position(x, np.zeros((2, 2)))
    r.set_velocities(np.arange(2), np.array([[0.02, 0.02], [0.0, 0.0]]))
    r.step()
r.debug()
