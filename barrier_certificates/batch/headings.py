"""Sines and cosines of headings, compiled without a call a robot.

Calls of the C library cost more than all else that a team does in a step. So angles are brought
within an eighth of a turn of a quarter turn, and the series of both functions are summed there,
until what is left out is below the last bit: a loop that a compiler turns into instructions for
four or eight robots at a time. Errors are one unit in the last place.
"""

from __future__ import annotations

import math

from barrier_certificates.array_types import FloatArray
from barrier_certificates.batch.compiling import compiled

#: A quarter turn as the sum of 33 bits and the rest: small multiples of the first are exact.
_QUARTER = math.floor(0.5 * math.pi * 2.0**32) / 2.0**32
_QUARTER_REST = 6.077100506506192e-11
_PER_QUARTER = 2.0 / math.pi

# Coefficients of the two series: (−1)ᵏ/(2k+1)! and (−1)ᵏ/(2k)!
_S3, _S5, _S7, _S9, _S11, _S13, _S15 = ((-1) ** k / math.factorial(2 * k + 1) for k in range(1, 8))
_C2, _C4, _C6, _C8, _C10, _C12, _C14, _C16 = (
    (-1) ** k / math.factorial(2 * k) for k in range(1, 9)
)


@compiled
def cosines_and_sines(angles: FloatArray, cosines: FloatArray, sines: FloatArray) -> None:
    """Write cosine and sine of each angle.

    Parameters
    ----------
    angles : (N,) array
        Angles, rad, up to 1e4, beyond which two parts of a quarter turn are not enough.
    cosines, sines : (N,) array
        Where they are written.
    """
    for k in range(angles.shape[0]):
        quarters = math.floor(angles[k] * _PER_QUARTER + 0.5) * 1.0
        r = (angles[k] - quarters * _QUARTER) - quarters * _QUARTER_REST
        z = r * r
        end_of_one = _S9 + z * (_S11 + z * (_S13 + z * _S15))
        sine = r + r * z * (_S3 + z * (_S5 + z * (_S7 + z * end_of_one)))
        end_of_other = _C10 + z * (_C12 + z * (_C14 + z * _C16))
        cosine = 1.0 + z * (_C2 + z * (_C4 + z * (_C6 + z * (_C8 + z * end_of_other))))
        odd = quarters - 2.0 * math.floor(0.5 * quarters)
        turned = quarters - 4.0 * math.floor(0.25 * quarters)
        one = cosine if odd == 1.0 else sine
        other = sine if odd == 1.0 else cosine
        sines[k] = -one if turned >= 2.0 else one
        cosines[k] = -other if (turned == 1.0) | (turned == 2.0) else other
