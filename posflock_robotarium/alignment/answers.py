"""What a user's metric may answer: one real number, or one for each sample.

>>> from posflock_robotarium.alignment.truth import known_flock
>>> run = known_flock("parallel", 0.1, duration=2.0).recording
>>> checked_answer(3, run, undefined=False)
3.0
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.logs.run import Run

Floats = NDArray[np.float64]


def checked_answer(answer: Any, run: Run, *, undefined: bool) -> float | Floats:
    """Return an answer as a number or as a curve, when it is one.

    Parameters
    ----------
    answer : object
        What a function of the user's returned.
    run : Run
        Of which it speaks; it says how many samples there are.
    undefined : bool
        Whether NaN means that the metric is undefined there.

    Returns
    -------
    float or (T,) array
        The same, in the same unit.

    Raises
    ------
    ParameterError
        When it is anything else; the words follow the function's name.
    """
    samples = len(run.t)
    expected = f"expected one real number, or one for each of the {samples} samples, ({samples},)"
    values = _real(answer, expected)
    if values.ndim > 1 or (values.ndim == 1 and len(values) != samples):
        raise ParameterError(f"returned shape {values.shape}; {expected}{_hint(values, run)}")
    _check_finite(values, run, undefined)
    return float(values) if values.ndim == 0 else values


def _real(answer: Any, expected: str) -> Floats:
    """Return an answer as floats; a mask reads as NaN."""
    if answer is None:
        raise ParameterError(f"returned None; {expected}: does it end with 'return'?")
    if isinstance(answer, np.ma.MaskedArray):
        masked: Any = answer.astype(float)
        answer = masked.filled(np.nan)
    try:
        values = np.asarray(answer)
    except (ValueError, TypeError) as error:
        raise ParameterError(
            f"returned {type(answer).__name__} that is no array ({error}); {expected}"
        ) from error
    if values.dtype.kind == "c":
        raise ParameterError(
            f"returned complex numbers ({values.dtype}); {expected}: take np.abs or .real"
        )
    if values.dtype.kind not in "biuf":
        kind = type(answer).__name__
        of = f" of {values.dtype}" if isinstance(answer, (np.ndarray, list, tuple)) else ""
        raise ParameterError(f"returned {kind}{of}; {expected}")
    return np.array(values, dtype=np.float64)


def _hint(values: Floats, run: Run) -> str:
    samples = len(run.t)
    if values.shape == (samples, run.robots):
        return ". One a robot? Take the mean, or the largest, over axis 1"
    if values.size == samples:
        return ". The values are as many: take .ravel()"
    if values.shape == (samples - 1,):
        return ". One is missing: differences are one fewer than samples; np.gradient is not"
    return ""


def _check_finite(values: Floats, run: Run, undefined: bool) -> None:
    """Refuse what is not finite, but where it may be undefined."""
    flat = np.atleast_1d(values)
    wrong = np.isinf(flat) if undefined else ~np.isfinite(flat)
    if values.ndim:
        # Nobody can say anything of robots that were not seen.
        wrong &= ~(np.isnan(flat) & np.isnan(run.poses[:, :2]).any(axis=(1, 2)))
    if not wrong.any():
        return
    first = int(np.flatnonzero(wrong)[0])
    got = "NaN" if np.isnan(flat[first]) else f"{flat[first]:g}"
    where = f" at {int(wrong.sum())} of {len(flat)} samples, first at {run.t[first]:.3f} s"
    advice = "" if run.headed else " The log has no headings, so these are NaN."
    raise ParameterError(
        f"returned {got}{where if values.ndim else ''}; expected finite numbers, or NaN where "
        f"undefined with may_be_undefined=True.{advice}"
    )
