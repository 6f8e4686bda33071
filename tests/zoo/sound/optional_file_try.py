"""Uses a warm start if it is there."""
import numpy as np
from rps.robotarium import Robotarium

try:
    start = np.load("last_poses.npy")
except FileNotFoundError:
    start = np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]])

r = Robotarium(number_of_robots=2, initial_conditions=start)
try:
    for k in range(60):
        x = r.get_poses()
        r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
        r.step()
finally:
    np.save("last_poses.npy", x)
    r.debug()
