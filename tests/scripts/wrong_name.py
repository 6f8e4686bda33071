import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(2, False, False, np.array([[-0.5, 0.5], [0, 0], [0, 0.0]]))
for k in range(20):
    r.get_poses()
    r.set_velocities(np.arange(2), np.zeros((2, 2)))
    r.step()
r.debug()
