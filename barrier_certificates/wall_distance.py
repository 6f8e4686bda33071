"""How far robots are from the walls: one definition, for runs, reports and verdicts."""

import numpy as np
from numpy.typing import NDArray


def wall_distances(
    positions: NDArray[np.float64], boundaries: tuple[float, float, float, float]
) -> NDArray[np.float64]:
    """Return how far inside the arena each robot stands: what a wall distance is, everywhere.

    Parameters
    ----------
    positions : (..., d, N) array
        Metres; the first two coordinates count, so poses will do.
    boundaries : (4,) tuple
        Least x, greatest x, least y, greatest y in metres.

    Returns
    -------
    (..., N) array
        Metres to the nearest wall; negative outside.
    """
    x, y = positions[..., 0, :], positions[..., 1, :]
    x_min, x_max, y_min, y_max = boundaries
    nearest: NDArray[np.float64] = np.minimum.reduce([x - x_min, x_max - x, y - y_min, y_max - y])
    return nearest
