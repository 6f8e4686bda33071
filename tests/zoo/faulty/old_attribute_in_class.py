"""An attribute of generation 1, of an instance made by another name and kept in a class."""
import numpy as np
from rps.robotarium import Robotarium as Testbed


class Team:
    def __init__(self, n):
        self.arena = Testbed(number_of_robots=n, initial_conditions=np.array([[-0.5, 0.5], [0, 0], [0, 0]], dtype=float))
        self.dt = self.arena.time_step  # <- generation

    def run(self, seconds):
        for _ in range(int(seconds / self.dt)):
            self.arena.get_poses()
            self.arena.set_velocities(np.arange(2), np.zeros((2, 2)))
            self.arena.step()


team = Team(2)
team.run(2.0)
team.arena.debug()
