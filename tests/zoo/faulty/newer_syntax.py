"""Python 3.11's except*."""
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
for _ in range(60):
    r.get_poses()
    r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
    r.step()
r.debug()

try:
    pass
except* ValueError:  # <- newer-python
    pass
