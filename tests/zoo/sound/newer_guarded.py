"""Newer things, asked for by version; quotes nested as 3.10 allows; a match statement."""
import sys

import numpy as np
from rps.robotarium import Robotarium

if sys.version_info >= (3, 11):
    import tomllib
    from typing import Self
else:
    Self = "Self"
    tomllib = None

info = {"gain": 0.5}
r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for k in range(60):
    x = r.get_poses()
    match k % 3:
        case 0 | 1:
            v = 0.02
        case _:
            v = 0.0
    r.set_velocities([0], np.array([[v], [0.1]]))
    r.step()
    if k == 59:
        print(f"gain {info['gain']:.2f} {'ok' if k else 'no'!r:>{10}} {x[0, 0]:+.3f}")
r.debug()
