import numpy as np
from rps.robotarium import Robotarium


class LoggedRobotarium(Robotarium):
    """Keeps what it does, and slows every command down."""

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.history = []
        self.slowness = 0.5

    def set_velocities(self, ids, velocities):
        super().set_velocities(ids, self.slowness * velocities)

    def step(self):
        self.history.append(self.poses.copy())
        super().step()

    def jump(self, x, y):
        self.poses[0, 0] = x
        self.poses[1, 0] = y


r = LoggedRobotarium(number_of_robots=2, show_figure=False, initial_conditions=np.array([[0, 1.0], [0, 0], [0, np.pi]]))
r.max_wheel_velocity = 5
for k in range(100):
    x = r.get_poses()
    if k == 50:
        r.jump(-1, -0.5)
    r.set_velocities(np.arange(2), np.array([[0.2, 0.2], [0, 0]]))
    r.step()
speed = np.linalg.norm(r.history[1][:2, 0] - r.history[0][:2, 0]) / r.time_step
print("speed %.3f" % speed, "steps", len(r.history), "x %.2f" % r.history[51][0, 0])
r.call_at_scripts_end()
