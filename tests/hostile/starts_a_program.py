"""Careless: notes which version it is."""
import subprocess
import sys

import numpy as np
from rps.robotarium import Robotarium

subprocess.run([sys.executable, "--version"])  # <- fork

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
