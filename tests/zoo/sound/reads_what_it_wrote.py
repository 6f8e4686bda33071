"""Writes a file, reads it again; and looks whether another is there before it reads that."""
import json
import os
from pathlib import Path

import numpy as np
from rps.robotarium import Robotarium

settings = {"speed": 0.05}
if os.path.exists("settings.json"):
    with open("settings.json") as file:
        settings.update(json.load(file))
calibration = Path("calibration.npy")
gain = np.load(calibration) if calibration.is_file() else 1.0
r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
log = open("log.csv", "a")
for k in range(60):
    x = r.get_poses()
    print(*x[:, 0], sep=",", file=log, flush=True)
    r.set_velocities([0], np.array([[gain * settings["speed"]], [0.0]]))
    r.step()
log.close()
print(len(open("log.csv").readlines()))
r.debug()
