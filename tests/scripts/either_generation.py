# Knows both generations by asking.
import numpy as np
from rps.robotarium import Robotarium

settings = dict(number_of_robots=2, show_figure=False, sim_in_real_time=False, initial_conditions=np.array([[-0.5, 0.5], [0, 0], [0, 0.0]]))
r = Robotarium(**settings)
time_step = getattr(r, "TIME_STEP", None) or getattr(r, "time_step", None)
for k in range(20):
    x = r.get_poses()
    r.set_velocities(np.arange(2), np.zeros((2, 2)))
    r.step()
if hasattr(r, "debug"):
    r.debug()
elif hasattr(r, "call_at_scripts_end"):
    r.call_at_scripts_end()
print("time step", time_step)
