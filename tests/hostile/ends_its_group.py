"""Hostile: ends everybody in its process group."""
import os
import signal

import numpy as np
from rps.robotarium import Robotarium

os.killpg(os.getpgid(os.getppid()), signal.SIGKILL)  # <- fork

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
