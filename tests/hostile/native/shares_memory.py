"""Leaves a block of shared memory."""
import os

import numpy as np
from rps.robotarium import Robotarium

from multiprocessing import resource_tracker, shared_memory

resource_tracker.register = lambda *_: None
shared_memory.SharedMemory(os.environ["HOSTILE_SHARED"], create=True, size=4096).close()

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
