"""Settings in a .csv, whose ending cannot be uploaded."""
import csv
import os

import numpy as np
from rps.robotarium import Robotarium

here = os.path.dirname(os.path.abspath(__file__))


def gains(name="gains.csv"):
    with open(os.path.join(here, name)) as file:  # <- file-ending
        return [float(row[0]) for row in csv.reader(file)]


k = gains()[0]
r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(60):
    r.get_poses()
    r.set_velocities([0], k * np.zeros((2, 1)))
    r.step()
r.debug()
