"""A certificate that each robot can compute by itself: from whom it sees, in its own program.

A robot takes its share of the row of every pair that it is in. A pair that is far enough apart
cannot break its row at top speed, so that a robot needs to see no farther than that; whoever it
does not see then changes nothing that it does.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.unicycle import UnicycleCertificate
from posflock_robotarium.flocking.errors import ParameterError


def local_certificate(
    certificate: UnicycleCertificate, radius: float | NDArray[np.float64]
) -> UnicycleCertificate:
    """Return the same certificate, decentralised; refuse one that needs robots to see farther.

    Parameters
    ----------
    certificate : UnicycleCertificate
        What is kept apart.
    radius : float or (N,) array
        How far robots see, m.

    Raises
    ------
    ParameterError
        Where two robots that do not see each other may break their row.
    """
    decentralised = replace(certificate, decentralised=True)
    needed, seen = decentralised.reach(), float(np.min(radius))
    if needed > seen:
        raise ParameterError(
            f"local: robots that see {seen:g} m cannot keep this certificate by themselves, whose"
            f" rows reach {needed:.3g} m; take a larger barrier_gain, a smaller safety_radius or a"
            " larger radius of the law"
        )
    return decentralised
