r"""Where the robots are by their commands, corrected slowly by where they are seen.

A real robot answers late: dead time and motor lag are about 0.37 s together.  The flocking
law acts on positions alone and has hardly any damping; fed with poses that are 0.37 s old it
amplifies its own oscillation, and nine robots with a perfect alignment in the simulator
(:math:`\gamma` = 1.000) tumble on the testbed (:math:`\gamma` from motion about 0.1).

The remedy is a complementary filter.  Its pose :math:`\hat x` moves as the commands say,
without delay, and is drawn to the tracked pose z at a slow rate L:

.. math:: \hat x \leftarrow f(\hat x, u) + L\,\Delta t\,(z - \hat x),

with f the unicycle model.  Above L rad/s the loop closes over the model, which does not
delay; below it over the measurement, which does not drift.  No dead time, lag or gain has to
be known, no velocity is measured, and where robots obey at once (the ideal simulator)
:math:`z = \hat x`: the filter changes nothing there.  It also takes the tracking noise out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import ParameterError

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class PoseFilterParameters:
    """How fast the filter believes what is seen.

    Attributes
    ----------
    rate : float
        L in 1/s, well below the inverse of the delay; 1/time_step or more follows the tracked
        poses at once, which is no filter.
    lost : float
        Metres between filtered and tracked position at which a robot was moved by something
        else than its commands; it is then believed to be where it is seen.

    Raises
    ------
    ParameterError
        Where a value is not finite and positive.
    """

    rate: float = 0.5
    lost: float = 0.15

    def __post_init__(self) -> None:
        for name in ("rate", "lost"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ParameterError(f"{name}: expected finite and more than zero, got {value!r}")


class PoseFilter:
    """The complementary filter of a team; call :meth:`update`, then :meth:`moved`, each step.

    Parameters
    ----------
    parameters : PoseFilterParameters
        How fast the filter follows what is seen.
    time_step : float
        Time from one command to the next, s.

    Examples
    --------
    A robot that obeys at once is where the filter says; nothing is corrected.

    >>> import numpy as np
    >>> filter = PoseFilter(PoseFilterParameters(), time_step=0.1)
    >>> filter.update(np.zeros((3, 1)))[0]
    array([0.])
    >>> filter.moved(np.array([[0.1], [0.0]]))
    >>> filter.update(np.array([[0.01], [0.0], [0.0]]))[0]
    array([0.01])
    """

    def __init__(self, parameters: PoseFilterParameters, time_step: float) -> None:
        self.parameters = parameters
        self.time_step = time_step
        self.reset()

    def reset(self) -> None:
        """Forget everything: the next poses are believed."""
        self._poses: Floats | None = None

    def update(self, seen: Floats) -> Floats:
        """Return the filtered poses now that the team has been seen.

        Parameters
        ----------
        seen : (3, N) array
            Poses as tracking reports them, m and rad.

        Returns
        -------
        (3, N) array
            Filtered poses, m and rad.
        """
        if self._poses is None:
            self._poses = seen.copy()
            return self._poses
        error = seen - self._poses
        error[2] = np.arctan2(np.sin(error[2]), np.cos(error[2]))
        lost = np.square(error[:2]).sum(axis=0) > self.parameters.lost**2
        error *= np.where(lost, 1.0, min(1.0, self.parameters.rate * self.time_step))
        self._poses = self._poses + error
        return self._poses

    def moved(self, command: Floats) -> None:
        """Move with the command just sent, for one time step.

        Parameters
        ----------
        command : (2, N) array
            Forward speeds, m/s, and turn rates, rad/s.

        Raises
        ------
        ParameterError
            Where no poses have been seen yet.
        """
        if self._poses is None:
            raise ParameterError("moved: the filter has seen no poses yet; call update first")
        x, dt = self._poses, self.time_step
        self._poses = x + dt * np.array(
            [command[0] * np.cos(x[2]), command[0] * np.sin(x[2]), command[1]]
        )
