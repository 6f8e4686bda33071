"""Two robots drive at each other: 0.6 m at 0.2 m/s, until 0.185 m are left."""
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.3, 0.3], [0.0, 0.0], [0.0, np.pi]]))
for _ in range(90):  # <~ collision 2.1
    r.get_poses()
    r.set_velocities(np.arange(2), np.array([[0.1, 0.1], [0.0, 0.0]]))
    r.step()
r.debug()
