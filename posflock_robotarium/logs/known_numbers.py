"""Which numbers of a log are any: poses and commands that no robot can have are unknown."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError

Floats = NDArray[np.float64]

FARTHEST = 1e4
"""Metres from the origin beyond which a position is taken for damage, not for a robot."""

LARGEST_HEADING = 1e6
"""Radians beyond which a heading is taken for damage (unwrapped headings stay far below)."""

LARGEST_COMMAND = 1e6
"""m/s or rad/s beyond which a command is taken for damage."""

LEAST_SEEN = 0.1
"""Share of robots and times that must be known, lest the numbers be no poses at all."""

MOST_DAMAGED = 0.5
"""Share of the numbers there are beyond which impossible ones mean that all are misread."""


def known_commands(commands: Floats) -> tuple[Floats | None, tuple[str, ...]]:
    """Return commands with NaN for whatever is none, and what is to be said of that.

    Parameters
    ----------
    commands : (T, 2, N) array
        m/s and rad/s, as logged.

    Returns
    -------
    commands : (T, 2, N) array or None
        The same, NaN where unknown; None where all are.
    notes : tuple of str
        One where any is.
    """
    with np.errstate(invalid="ignore"):
        known = (np.abs(commands) <= LARGEST_COMMAND).all(axis=1)
    unknown = np.array(~known, ndmin=2)
    if not unknown.any():
        return commands, ()
    row, robot = (int(index) for index in np.argwhere(unknown)[0])
    note = (
        f"{int(unknown.sum())} of {unknown.size} commands are no numbers, or none that a robot can "
        f"be given: unknown (the first: row {row}, robot {robot})"
    )
    if unknown.all():
        return None, (note,)
    if bool(np.isnan(commands[unknown.nonzero()[0], :, unknown.nonzero()[1]]).all()):
        return commands, (note,)
    return np.where(unknown[:, np.newaxis], np.nan, commands), (note,)


def known_poses(where: str, poses: Floats) -> tuple[Floats, str]:
    """Return poses with NaN for whatever is none, and what is to be said of that.

    Parameters
    ----------
    where : str
        File name for messages.
    poses : (T, 3, N) array
        m and rad, as logged.

    Returns
    -------
    poses : (T, 3, N) array
        The same, NaN where a robot was not seen.
    note : str
        Empty where there is nothing to be said.

    Raises
    ------
    LogError
        Where too few are known, or most are none.
    """
    # One reduction for the common, sound case; the rest is only looked at when there is some.
    with np.errstate(invalid="ignore"):
        positions_sound = bool(np.abs(poses[:, :2]).max() <= FARTHEST)
        headings_sound = bool(np.abs(poses[:, 2]).max() <= LARGEST_HEADING)
    if positions_sound and (headings_sound or bool(np.isnan(poses[:, 2]).all())):
        return poses, ""
    limit = np.array([FARTHEST, FARTHEST, LARGEST_HEADING])[:, np.newaxis]
    with np.errstate(invalid="ignore"):
        absurd = np.abs(poses) > limit
    said = ""
    if absurd.any():
        row, axis, robot = (int(index) for index in np.argwhere(absurd)[0])
        first = f"row {row}: {('x', 'y', 'heading')[axis]} of robot {robot} is "
        first += f"{poses[row, axis, robot]:g}"
        if absurd.sum() > MOST_DAMAGED * (~np.isnan(poses)).sum():
            raise LogError(
                f"{where}: {first}, no place a robot can be, and so are most of its numbers: is it "
                "damaged, or of another form?"
            )
        said = f"{int(absurd.sum())} numbers that no robot can have are unseen ({first})"
    known = np.array(poses, dtype=float)
    known[absurd] = np.nan
    unseen = np.isnan(known[:, :2]).any(axis=1)
    known.transpose(0, 2, 1)[unseen] = np.nan
    share = 1.0 - float(unseen.mean())
    if share < LEAST_SEEN or int((~unseen.all(axis=1)).sum()) < 2:
        raise LogError(
            f"{where}: only {share:.0%} of its poses are known ({int((~unseen).sum())} of "
            f"{unseen.size}, all else is NaN or no place a robot can be); expected at least two "
            f"times, and {LEAST_SEEN:.0%}"
        )
    # Poses that are known to be NaN already stay the same array.
    same = not absurd.any() and bool((np.isnan(known) == np.isnan(poses)).all())
    return (poses if same else known), said
