"""input under another name, from builtins."""
import builtins
import numpy as np
from rps.robotarium import Robotarium

ask = builtins.input


def main():
    r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
    ask("start? ")  # <- blocking-call
    for _ in range(60):
        r.get_poses()
        r.set_velocities([0], np.zeros((2, 1)))
        r.step()
    r.debug()


main()
