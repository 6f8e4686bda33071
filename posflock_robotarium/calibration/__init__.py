r"""What a returned log says about the testbed: dead time, lag, gains, bias and noise, fitted.

A log that holds commands u next to tracked poses is an open-loop experiment, whatever closed the
loop.  The model is the one that realism profiles simulate: commands pass a dead time
:math:`\tau_d` and a first-order lag :math:`\tau_l`, both the team's; then robot i drives

.. math:: v = g^v_i F(u_v), \qquad \omega = g^\omega_i F(u_\omega) + b_i,

with F the delayed and lagged command, integrated over each step as long as it took.  Poses are seen
with white jitter and a heading offset.

The fit looks at increments between frames: of the heading, and of the position along the
heading.  For given :math:`\tau_d, \tau_l` they are linear in gains and bias, so those are solved
for exactly and the search is over two numbers (variable projection).  An increment's noise is what
the model does not explain, w, plus the difference of two jitters,

.. math:: e_k = w_k + n_{k+1} - n_k,

so neighbouring increments are correlated, by minus the jitter's variance.  Their covariance is
tridiagonal; both variances are found by maximum likelihood, and the fit is repeated with the
increments whitened by them, which makes the intervals honest.  Both variances are results, too.

Three things come before and after.  Poses that are no robot's (teleports, placeholders, mistaken
identities) are left out.  Step times are recorded, or counted, and then the gains are biased by
what they hide.  And a parameter whose interval says nothing is left out and named, by the
information matrix, so that the others can still be fitted.

Heading offsets are found as the angle between the heading that is seen and the course that is
driven.
"""

from posflock_robotarium.calibration.estimate import Estimate
from posflock_robotarium.calibration.identifiability import FittedParameter, LeftOut
from posflock_robotarium.calibration.log_to_profile import calibrate
from posflock_robotarium.calibration.resimulate import (
    read_commanded,
    resimulate,
    write_profile,
)
from posflock_robotarium.calibration.response import delayed
from posflock_robotarium.calibration.result import Calibration
from posflock_robotarium.calibration.step_times import read_step_times, retimed

__all__ = [
    "Calibration",
    "Estimate",
    "FittedParameter",
    "LeftOut",
    "calibrate",
    "delayed",
    "read_commanded",
    "read_step_times",
    "resimulate",
    "retimed",
    "write_profile",
]
