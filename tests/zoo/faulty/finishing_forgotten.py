"""The finishing call is the name of a switch only."""
import numpy as np
from rps.robotarium import *


class Runner:
    debug = False

    def __init__(self):
        self.r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))  # <~ no-finishing-call

    def __call__(self):
        for _ in range(60):
            self.r.get_poses()
            self.r.set_velocities([0], np.zeros((2, 1)))
            self.r.step()
            if self.debug:
                print("step")


Runner()()
