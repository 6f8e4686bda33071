# Generation 1 ignores the ids; people pass what they like.
import numpy as np
import rps.robotarium as robotarium

INITIAL = np.array([[0, 1, -1], [0, 0, 0], [0, 1, 2]])   # integers
r = robotarium.Robotarium(number_of_robots=3, show_figure=False, sim_in_real_time=False, initial_conditions=INITIAL)
for ids in (None, [0], 0, [0, 1, 2], np.arange(3), "all"):
    r.get_poses()
    r.set_velocities(ids, np.array([[0.1, 0.1, 0.1], [0.0, 0.0, 0.0]]))
    r.step()
assert (INITIAL == np.array([[0, 1, -1], [0, 0, 0], [0, 1, 2]])).all()
print("%.4f" % r.get_poses()[0, 0])
r.call_at_scripts_end()
