"""An object drives, and is asked to save in ``finally``."""
import numpy as np
from rps.robotarium import Robotarium


class Experiment:
    def __init__(self):
        self.seen = []
        start = np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]])
        self.r = Robotarium(number_of_robots=2, initial_conditions=start)

    def tick(self):
        self.seen.append(self.r.get_poses())
        self.r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
        self.r.step()

    def close(self):
        self.save()
        self.r.debug()

    def save(self):
        np.save("poses.npy", np.array(self.seen))


experiment = Experiment()
try:
    for _ in range(60):
        experiment.tick()
finally:
    experiment.close()
