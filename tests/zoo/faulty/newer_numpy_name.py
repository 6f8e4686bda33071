"""A name that came to numpy after the testbed's version."""
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
print(np.strings.slice(np.array(["robots"]), 5))  # <- newer-library
for _ in range(60):
    r.get_poses()
    r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
    r.step()
r.debug()
