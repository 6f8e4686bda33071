"""A grid of 24 robots, counted from its sides."""
import numpy as np
from rps.robotarium import Robotarium

rows, columns = 4, 6
N = rows * columns


def grid():
    x, y = np.meshgrid(np.linspace(-1.2, 1.2, columns), np.linspace(-0.7, 0.7, rows))
    return np.vstack([x.ravel(), y.ravel(), np.zeros(N)])


r = Robotarium(number_of_robots=N, initial_conditions=grid())  # <- too-many-robots
for _ in range(60):
    r.get_poses()
    r.set_velocities(np.arange(N), np.zeros((2, N)))
    r.step()
r.debug()
