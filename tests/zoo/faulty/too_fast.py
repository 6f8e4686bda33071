"""Commands 0.5 m/s to wheels that make 0.2; turning on the spot it stays inside."""
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
for k in range(200):  # <~ actuator 1.0
    r.get_poses()
    fast = np.array([[0.0], [8.0]]) if k * 0.033 >= 1.0 else np.zeros((2, 1))
    r.set_velocities([0], fast)
    r.step()
r.debug()
