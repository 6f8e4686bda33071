"""Counts 99 s of steps where 60 are declared."""
# declared: 60
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
k = 0
while k < 3000:  # <~ duration 60.0
    r.get_poses()
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
    k += 1
r.debug()
