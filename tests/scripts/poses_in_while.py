# get_poses() is called in the loop, but its first result stands in the condition.
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(1, False, False, np.array([[-0.5], [0.0], [0.0]]))
pose = r.get_poses()
r.step()
steps = 0
while pose[0, 0] < 0.5:
    r.get_poses()
    r.set_velocities([0], np.array([[0.15], [0.0]]))
    r.step()
    steps += 1
print("arrived after", steps)
r.call_at_scripts_end()
