"""The loop adds to a log, which writes itself every tenth row."""
import numpy as np
from rps.robotarium import Robotarium


def main():
    start = np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]])
    r = Robotarium(number_of_robots=2, initial_conditions=start)
    log = Log("poses.npy")
    for _ in range(60):
        log.add(r.get_poses())
        r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
        r.step()
    log.flush()
    r.debug()


class Log:
    def __init__(self, path):
        self.path = path
        self.rows = []

    def add(self, row):
        self.rows.append(row)
        if len(self.rows) % 10 == 0:
            self.flush()

    def flush(self):
        np.save(self.path, np.array(self.rows))


main()
