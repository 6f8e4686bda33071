"""How far a number over runs can be trusted: 95 % intervals of a share, a median and a mean.

Runs are the unit, because samples within a run are anything but independent.  A share gets
Wilson's score interval; a median or a mean a percentile bootstrap: as many runs as there are, are
drawn from them with replacement, thousands of times, and the middle 95 % of what is found is the
interval.  What is drawn is seeded, so that the same values give the same interval.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.fewest_runs import FEWEST_RUNS

Floats = NDArray[np.float64]

#: Of every interval.
CONFIDENCE = 0.95
#: How often runs are drawn again, for a median and for a mean.
MEDIAN_RESAMPLES, MEAN_RESAMPLES = 2_000, 10_000


def wilson_interval(successes: int, trials: int, z: float = 1.959964) -> tuple[float, float]:
    """Return Wilson's score interval of a proportion, 95 % by default.

    Unlike the textbook ± it stays inside [0, 1] and says something after 0 of n: up to
    z²/(n + z²), which is 16 % after 0 of 20.  Wilson, J. Am. Stat. Assoc. 22 (1927) 209.

    Parameters
    ----------
    successes : int
        In how many trials it happened.
    trials : int
        Number of trials, 1 or more.
    z : float
        Quantile of the normal distribution: 1.96 for 95 %.

    Raises
    ------
    ValueError
        Where the numbers are no proportion.
    """
    if trials < 1 or not 0 <= successes <= trials:
        raise ValueError(f"expected 0 ≤ successes ≤ trials ≥ 1, got {successes} of {trials}")
    share, spread = successes / trials, z * z / trials
    centre = (share + spread / 2) / (1 + spread)
    half = z * math.sqrt(share * (1 - share) / trials + spread / (4 * trials)) / (1 + spread)
    low = 0.0 if successes == 0 else centre - half
    high = 1.0 if successes == trials else centre + half
    return max(0.0, low), min(1.0, high)


def told_interval(successes: int, trials: int) -> tuple[float, float] | None:
    """Return the same where there are enough trials to tell one; None otherwise.

    Parameters
    ----------
    successes : int
        In how many trials it happened.
    trials : int
        Number of trials, 1 or more.
    """
    return wilson_interval(successes, trials) if trials >= FEWEST_RUNS else None


def median_interval(values: Floats) -> tuple[float, float]:
    """Return the bootstrap interval of the median, the same for the same values in any order.

    Parameters
    ----------
    values : (n,) array
        One number of every run, in any unit; infinite ones count, too.

    Returns
    -------
    pair of float
        Its ends, in the same unit; NaN of fewer than `FEWEST_RUNS` runs, which tell none, and
        where a value is NaN.
    """
    if len(values) < FEWEST_RUNS or np.isnan(values).any():
        return math.nan, math.nan
    ordered, (below, above) = np.sort(values), _ranks_of_medians(len(values))
    # Runs that never aligned are infinite: "nearest" picks one, where others interpolate.
    medians = (ordered[below] + ordered[above]) / 2.0
    tail = 50.0 * (1.0 - CONFIDENCE)
    low, high = np.percentile(medians, [tail, 100.0 - tail], method="nearest")
    return float(low), float(high)


@lru_cache(maxsize=64)
def _ranks_of_medians(runs: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return which two of the runs, in order of size, are in the middle of each resample.

    Draws do not depend on the values, so that what takes long is done once for each number of
    runs: a table has hundreds of medians over equally many.
    """
    middle = [(runs - 1) // 2, runs // 2]
    drawn = np.random.default_rng(runs).integers(runs, size=(MEDIAN_RESAMPLES, runs))
    drawn.partition(middle, axis=1)
    return drawn[:, middle[0]].copy(), drawn[:, middle[1]].copy()


def mean_interval(values: Floats, *, seed: int = 0) -> tuple[float, float]:
    """Return the bootstrap interval of the mean.

    Parameters
    ----------
    values : (n,) array
        One number of every run, in any unit.
    seed : int
        Of the resampling: the same seed gives the same interval.

    Returns
    -------
    pair of float
        Its ends, in the same unit; NaN of fewer than `FEWEST_RUNS` runs, which tell none.
    """
    if len(values) < FEWEST_RUNS:
        return math.nan, math.nan
    rng = np.random.default_rng(seed)
    drawn = rng.integers(0, len(values), size=(MEAN_RESAMPLES, len(values)))
    tail = 0.5 * (1.0 - CONFIDENCE)
    low, high = np.quantile(values[drawn].mean(axis=1), [tail, 1.0 - tail])
    return float(low), float(high)
