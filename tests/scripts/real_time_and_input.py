import time
from time import sleep
import numpy as np
from rps.robotarium import Robotarium

answer = input("How fast? ")
speed = float(answer or 0.05)
r = Robotarium(number_of_robots=1, show_figure=True, sim_in_real_time=True, initial_conditions=np.zeros((3, 1)))
start = time.time()
steps = 0
while time.time() - start < 5:          # five seconds of the experiment
    r.get_poses()
    r.set_velocities(np.array([0]), np.array([[speed], [0]]))
    r.step()
    sleep(0.067)
    time.sleep(0.1)
    steps += 1
name = input("Name of the data file? ")
print("steps", steps, "speed", speed, repr(name))
r.call_at_scripts_end()
