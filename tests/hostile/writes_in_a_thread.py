"""Hostile: lets a thread write elsewhere, and goes on."""
import os
import threading

import numpy as np
from rps.robotarium import Robotarium

OUTSIDE = os.environ["HOSTILE_OUTSIDE"]
VICTIM = os.path.join(OUTSIDE, "victim.txt")
thread = threading.Thread(target=np.save, args=(os.path.join(OUTSIDE, "poses.npy"), np.zeros(3)))  # <~ outside-write
thread.start()
thread.join()

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
