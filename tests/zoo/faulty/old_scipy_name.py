"""A name that scipy has dropped."""
import numpy as np
from rps.robotarium import Robotarium
from scipy.integrate import simps  # <- removed-from-library

r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
for _ in range(60):
    r.get_poses()
    r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
    r.step()
r.debug()
print(simps([1.0, 2.0, 3.0]))
