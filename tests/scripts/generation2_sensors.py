import numpy as np
from rps.robotarium import Robotarium

walls = np.array([[[-1.6, -1], [1.6, -1]], [[1.6, -1], [1.6, 1]], [[1.6, 1], [-1.6, 1]], [[-1.6, 1], [-1.6, -1]], [[0.3, -0.4], [0.3, 0.4]]])
r = Robotarium(number_of_robots=3, show_figure=True, sim_in_real_time=False, use_distance_sensors=True,
               show_distance_rays=True, obstacles=walls, skip_initialization=True,
               initial_conditions=np.array([[-0.8, 0.0, 0.9], [0.0, 0.3, -0.3], [0.0, -0.5, 3.0]]))
for k in range(100):
    x = r.get_poses()
    d = r.get_distances()
    front = np.nan_to_num(d[3], nan=1.0)
    turn = np.where((front > 0) & (front < 0.3), 1.5, 0.0)
    r._leds[:, turn > 0] = np.array([[255], [0], [0]])
    r.set_velocities(np.arange(3), np.vstack([0.1 * np.ones(3), turn]))
    r.step()
print(r.get_encoders().shape, r.get_accelerations().shape, r.get_gyros().shape, r.get_magnetic_fields().shape, r.get_orientations().shape, r.get_distance_endpoints().shape)
print(bool((r.get_encoders() != 0).any()))
r.debug()
