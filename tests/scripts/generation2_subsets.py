import numpy as np
from rps.robotarium import Robotarium


class Slow(Robotarium):
    MAX_WHEEL_VELOCITY = 5.0
    ENCODER_NOISE_STD = 0.0

    def simulate_gyros(self):
        super().simulate_gyros()
        self.simulated = getattr(self, "simulated", 0) + 1


r = Slow(number_of_robots=4, show_figure=False, sim_in_real_time=False, skip_initialization=True,
         initial_conditions=np.array([[-1, -0.5, 0.5, 1], [0, 0, 0, 0], [0, 0, 0, 0.0]]))
r.get_poses()
r.set_velocities(np.arange(4), 0.02 * np.ones((2, 4)))
r.step()
for k in range(30):
    r.get_poses()
    r.set_velocities(np.array([k % 4]), np.array([[0.2], [0.0]]))   # the others keep theirs
    r.step()
print(np.round(r._velocities[0], 3), r.simulated)
r.debug()
