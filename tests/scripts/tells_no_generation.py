import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0, 0], [0, 0.0]]))
for k in range(5):
    x = r.get_poses()
    r.set_velocities(np.arange(2), np.zeros((2, 2)))
    r.step()
print("there", x.shape)
