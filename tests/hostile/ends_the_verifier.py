"""Hostile: ends the process that has started it."""
import os
import signal

import numpy as np
from rps.robotarium import Robotarium

os.kill(os.getppid(), signal.SIGKILL)  # <- fork

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
