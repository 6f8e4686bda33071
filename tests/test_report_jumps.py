"""A report names poses that no wheels can reach, and does not call them sharp."""

import numpy as np
import pytest
from rolling_robots import rolling

from posflock_robotarium.alignment.verdicts import Mark
from posflock_robotarium.report import Run, analyse

T, POSES = rolling(300, 4)


def lost(value):
    poses = POSES.copy()
    poses[100:140, :, 2] = value
    return poses


def swapped():
    poses = POSES.copy()
    poses[150:, :, [0, 1]] = poses[150:, :, [1, 0]]
    return poses


def sure(poses):
    verdicts = analyse(Run("run", T, poses), radius=1.0).verdicts
    return next(verdict for verdict in verdicts if verdict.question == "How sure are we?")


@pytest.mark.parametrize(
    ("poses", "named"),
    [
        (lost(0.0), "robot 2, 3.3 to 4.6 s: not tracked"),
        (lost(-9999.0), "robot 2, 3.3 to 4.6 s: not tracked"),
        (swapped(), "robot 0 at 5.0 s; robot 1 at 5.0 s"),
    ],
)
def test_jumps_are_named_with_robot_and_time(poses, named):
    verdict = sure(poses)
    assert verdict.mark is Mark.CAUTION
    assert named in verdict.because


def test_a_team_that_no_wheels_can_drive_is_not_believed(tmp_path):
    assert "no such robot" in sure(POSES * np.array([[20.0], [20.0], [1.0]])).answer


def test_sound_poses_are_sure():
    assert sure(POSES).mark is not Mark.BAD
