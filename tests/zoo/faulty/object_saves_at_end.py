"""An object drives, and is asked to save when it has."""
import numpy as np
from rps.robotarium import Robotarium


class Experiment:
    def __init__(self):
        self.seen = []
        start = np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]])
        self.r = Robotarium(number_of_robots=2, initial_conditions=start)

    def save(self):
        np.savez("poses.npz", poses=np.array(self.seen))  # <- save-at-end

    def run(self):
        for _ in range(60):
            self.seen.append(self.r.get_poses())
            self.r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
            self.r.step()
        self.r.debug()


experiment = Experiment()
experiment.run()
experiment.save()
