"""Commands once and drives on: the watchdog brakes after 0.5 s."""
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
r.get_poses()
r.set_velocities([0], np.array([[0.05], [0.0]]))
r.step()
for k in range(90):  # <~ watchdog
    r.get_poses()
    r.step()
r.debug()
