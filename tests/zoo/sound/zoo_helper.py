"""What local_helper.py imports."""
import numpy as np


def spin(robots):
    """Turn on the spot."""
    return np.array([np.zeros(robots), np.full(robots, 0.3)])
