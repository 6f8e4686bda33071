"""except* of Python 3.11, in a class."""
import numpy as np
from rps.robotarium import Robotarium


class Experiment:
    def __init__(self):
        self.robotarium = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))

    def run(self):
        try:
            for _ in range(60):
                self.robotarium.get_poses()
                self.robotarium.set_velocities([0], np.zeros((2, 1)))
                self.robotarium.step()
        except* ValueError as problems:  # <- newer-python
            print(problems)
        self.robotarium.debug()


Experiment().run()
