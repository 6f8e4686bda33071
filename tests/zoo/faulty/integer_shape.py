"""Initial conditions of the wrong shape."""
import numpy as np
from rps.robotarium import Robotarium

start = np.zeros((2, 3))
r = Robotarium(number_of_robots=3, initial_conditions=start)  # <- unreachable-start
r.debug()
