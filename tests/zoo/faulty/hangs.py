"""Stops stepping at t = 1 s."""
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
for k in range(60):
    x = r.get_poses()
    while k == 31: pass  # <- hang
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
r.debug()
