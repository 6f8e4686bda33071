r"""How robots follow their commands: a dead time, then a first-order lag, in continuous time.

A command holds from the row in which it was sent to the next, however long that took.  It takes
effect a dead time later, somewhere within a step, and from then on the speed approaches it
exponentially.  Between two such moments the equation :math:`\tau \dot y = u - y` has constant
input, so that

.. math:: y(s + h) = u + (y(s) - u) e^{-h/\tau}, \qquad
          \int_s^{s+h} y = u h + \tau (1 - e^{-h/\tau}) (y(s) - u)

hold exactly, for steps of any length.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solve_banded

Floats = NDArray[np.float64]


def delayed(
    commands: Floats,
    dead_time: float,
    lag: float,
    steps: ArrayLike,
    before: ArrayLike = 0.0,
) -> Floats:
    """Return what robots drive on average in each step, of what they are commanded.

    Parameters
    ----------
    commands : (K, ...) array
        One row a step, held for the step.
    dead_time, lag : float
        Seconds.
    steps : float or (K,) array
        How long each step takes, s.
    before : (...) array
        What they had been commanded, and drove, before the first row; at rest by default.

    Returns
    -------
    (K, ...) array
        What they drive, in the unit of the commands.
    """
    rows = len(commands)
    steps = np.broadcast_to(np.asarray(steps, dtype=float), (rows,))
    edges = np.concatenate([[0.0], np.cumsum(steps)])
    changes = edges[:-1] + dead_time
    moments = np.sort(np.concatenate([edges, changes[changes < edges[-1]]]))
    length, middle = np.diff(moments), (moments[1:] + moments[:-1]) / 2
    flat = commands.reshape(rows, -1)
    first = np.broadcast_to(np.asarray(before, dtype=float), commands.shape[1:]).reshape(1, -1)
    input_ = np.concatenate([first, flat])[np.searchsorted(changes, middle)]
    away = _gap_to_input(input_, length, first[0], lag)
    way = input_ * length[:, None] + lag * -np.expm1(-length / lag)[:, None] * away
    out: Floats = np.add.reduceat(way, np.searchsorted(middle, edges[:-1]))
    out /= steps[:, None]
    return out.reshape(commands.shape)


def _gap_to_input(input_: Floats, length: Floats, first: Floats, lag: float) -> Floats:
    """Return by how much the state is off its input (n, M) at the beginning of each stretch."""
    kept = np.exp(-length / lag)
    # y[i + 1] - kept[i] y[i] = (1 - kept[i]) u[i] for all i at once: a bidiagonal system.
    known = (1 - kept)[:, None] * input_
    known[0] += kept[0] * first
    bands = np.stack([np.ones(len(length)), np.append(-kept[1:], 0.0)])
    after = solve_banded((1, 0), bands, known, check_finite=False)
    gap: Floats = np.concatenate([first[None], after[:-1]]) - input_
    return gap
