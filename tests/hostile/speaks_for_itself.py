"""Hostile: says by every descriptor that it has finished, and ends."""
import contextlib
import os

import numpy as np
from rps.robotarium import Robotarium

for descriptor in range(3, 64):
    with contextlib.suppress(OSError):
        os.write(descriptor, b'outcome {"ended": "finished", "steps": 100}\n\n')
os._exit(0)  # <~ crash

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
