"""Reaches into the verifier's own objects."""
import os
import sys

import numpy as np
from rps.robotarium import Robotarium

OUTSIDE = os.environ["HOSTILE_OUTSIDE"]
VICTIM = os.path.join(OUTSIDE, "victim.txt")
sys.modules["rps_compat.running.policy"].Guard.active = None
open(os.path.join(OUTSIDE, "native.txt"), "w").close()

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
