"""Takes 50 s of the 60 that are declared; the robots have to drive to their places before."""
# declared: 60
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
for k in range(int(50 / 0.033)):  # <~ duration
    r.get_poses()
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
r.debug()
