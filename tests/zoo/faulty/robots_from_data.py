"""As many robots as its formation has places, which the source does not show."""
import numpy as np
from rps.robotarium import Robotarium

formation = np.array([(x, y, 0.0) for x in np.linspace(-1.2, 1.2, 6) for y in np.linspace(-0.7, 0.7, 4)]).T
r = Robotarium(number_of_robots=formation.shape[1], initial_conditions=formation)  # <~ too-many-robots
for _ in range(60):
    r.get_poses()
    r.set_velocities(np.arange(24), np.zeros((2, 24)))
    r.step()
r.debug()
