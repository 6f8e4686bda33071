"""Twenty-four robots; the simulator takes them."""
import numpy as np
from rps.robotarium import Robotarium

N = 4 * 6
x, y = np.meshgrid(np.linspace(-1.25, 1.25, 6), np.linspace(-0.75, 0.75, 4))
start = np.array([x.ravel(), y.ravel(), np.zeros(N)])
r = Robotarium(number_of_robots=N, initial_conditions=start)  # <- too-many-robots
for _ in range(60):
    r.get_poses()
    r.set_velocities(np.arange(N), np.zeros((2, N)))
    r.step()
r.debug()
