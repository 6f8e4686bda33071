"""How long robots drive to their initial conditions, predicted from published drives.

Before an experiment the testbed drives the robots from wherever they stand to where the script
wants them, by a planner of its own that is not published. Eleven public logs tell how long that
took. What explains them is the number of robots: the logarithm of the time grows with it in a
straight line, and drives of the same number differ by a factor of 1.5 up and down. Distances
explain nothing beyond: simulated drives of slow robots to the same places take 13 to 23 s from
starts that were well assigned, and 26 to 41 s from starts that were not, whether the real one took
34 s or 192. So a simulated drive is taken for no more than the least that a real one takes.

>>> print(predicted_drive(9))
24 to 121 s (median 54)
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

#: Robots and seconds of published drives: ten of June and July 2026 (the stamps of their logs, in
#: kevinkawchak/robotarium-nurse-patient-study), and one of two robots.
PUBLISHED = (
    (14, 48.8), (16, 130.6), (16, 102.4), (10, 80.6), (11, 58.2), (16, 192.1),
    (16, 115.8), (12, 118.4), (13, 56.3), (10, 33.9), (2, 31.0),
)  # fmt: skip

#: Two-sided 90 % quantile of Student's distribution with n − 2 degrees of freedom, by n.
_STUDENT = {10: 1.860, 11: 1.833}


@dataclass(frozen=True)
class DriveTime:
    """Seconds that a drive to the initial conditions is predicted to take.

    Attributes
    ----------
    least, median, most : float
        The middle, and the ends of an interval that is to hold nine drives of ten, s.
    """

    least: float
    median: float
    most: float

    def __str__(self) -> str:
        return f"{self.least:.0f} to {self.most:.0f} s (median {self.median:.0f})"

    def as_dict(self) -> dict[str, float]:
        """Return what ``verify.json`` holds of it."""
        return {"least": self.least, "median": self.median, "most": self.most}


def predicted_drive(
    robots: int,
    simulated: float | None = None,
    published: Sequence[tuple[int, float]] = PUBLISHED,
) -> DriveTime:
    """Predict how long driving to the initial conditions takes.

    Parameters
    ----------
    robots : int
        How many drive.
    simulated : float, optional
        Seconds of the same drive in the simulator: the real one takes no less.
    published : sequence of (int, float)
        Robots and seconds of the drives to learn from, ten or eleven.
    """
    number = len(published)
    logs = [math.log(seconds) for _, seconds in published]
    centre, mean = sum(n for n, _ in published) / number, sum(logs) / number
    spread = sum((n - centre) ** 2 for n, _ in published)
    slope = sum((n - centre) * log for (n, _), log in zip(published, logs, strict=True)) / spread
    left = [log - mean - slope * (n - centre) for (n, _), log in zip(published, logs, strict=True)]
    sigma = math.sqrt(sum(residual**2 for residual in left) / (number - 2))
    middle = mean + slope * (robots - centre)
    half = _STUDENT[number] * sigma * math.sqrt(1 + 1 / number + (robots - centre) ** 2 / spread)
    floor = simulated or 0.0
    return DriveTime(*(max(floor, math.exp(middle + k * half)) for k in (-1, 0, 1)))
