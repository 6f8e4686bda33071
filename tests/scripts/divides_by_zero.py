import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=3, show_figure=False, sim_in_real_time=False, initial_conditions=np.array([[-0.5, 0.5, 1.0], [0, 0, 0], [0, 0, 0.0]]))
for k in range(20):
    x = r.get_poses()
    v = np.zeros((2, 3))
    if k == 7:
        v[1, 2] = 0.0 * float('inf')
    r.set_velocities(np.arange(3), v)
    r.step()
r.call_at_scripts_end()
