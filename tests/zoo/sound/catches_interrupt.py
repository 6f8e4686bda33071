"""Catches the interrupt and saves after it."""
import numpy as np
from rps.robotarium import Robotarium


def main():
    r = Robotarium(number_of_robots=1, initial_conditions=np.array([[0.0], [0.0], [0.0]]))
    seen = []
    try:
        drive(r, seen)
    except KeyboardInterrupt:
        print("interrupted")
    np.savetxt("poses.txt", np.array(seen)[:, :, 0])
    r.debug()


def drive(r, seen):
    for k in range(90):
        seen.append(r.get_poses())
        r.set_velocities([0], np.array([[0.05], [0.5]]))
        r.step()


if __name__ == "__main__":
    main()
