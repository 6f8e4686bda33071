"""Is not Python."""
import numpy as np
from rps.robotarium import Robotarium
r = Robotarium(number_of_robots=2  # <- syntax
for k in range(3):
    r.step()
