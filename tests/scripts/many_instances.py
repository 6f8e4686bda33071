# A parameter study: one simulation for each gain.
import numpy as np
import rps.robotarium as robotarium

found = []
for gain in np.linspace(0.1, 1, 12):
    r = robotarium.Robotarium(number_of_robots=2, show_figure=True, sim_in_real_time=False, initial_conditions=np.array([[-0.3, 0.3], [0, 0], [0, np.pi]]))
    for k in range(60):
        x = r.get_poses()
        r.set_velocities(np.arange(2), np.array([[0.2 * gain] * 2, [0, 0]]))
        r.step()
    collisions = sum(v for key, errors in r._errors.items() if key == "collision" for v in errors.values())
    found.append(collisions)
    r.call_at_scripts_end()
print(found)
