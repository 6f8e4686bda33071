"""Subclasses Robotarium, as published scripts do."""
import numpy as np
from rps.robotarium import Robotarium


class Counting(Robotarium):
    steps = 0

    def step(self):
        self.steps += 1
        super().step()


r = Counting(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
while r.steps < 60:
    r.get_poses()
    r.set_velocities([0], np.array([[0.02], [0.3]]))
    r.step()
r.debug()
