"""Says that it is done in a file of the folder above."""
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
for _ in range(60):
    r.get_poses()
    r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
    r.step()
r.debug()
with open("../posflock-zoo.txt", "w") as file:  # <- outside-write
    file.write("done")
