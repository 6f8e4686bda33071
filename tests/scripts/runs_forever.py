# As on the testbed: the loop has no end, and swallows everything.
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=2, show_figure=True, sim_in_real_time=True, initial_conditions=np.array([[0, 0.5], [0, 0], [0, 0.0]]))
while True:
    try:
        x = r.get_poses()
        r.set_velocities(np.arange(2), np.array([[0.02, 0.02], [0.5, 0.5]]))
        r.step()
    except Exception as e:
        print("never mind", e)
