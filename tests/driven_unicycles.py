"""Unicycles whose projection points a certificate drives, and the arena that they drive in."""

import numpy as np

ARENA = (-1.6, 1.6, -1.0, 1.0)
STEP = 0.033
D = 0.05  # projection distance


def unicycle_step(poses, velocity):
    """Move unicycles by what their projection points shall do; return poses, v, ω."""
    e = np.stack([np.cos(poses[2]), np.sin(poses[2])])
    v, w = (velocity * e).sum(axis=0), (e[0] * velocity[1] - e[1] * velocity[0]) / D
    return poses + STEP * np.stack([v * e[0], v * e[1], w]), v, w
