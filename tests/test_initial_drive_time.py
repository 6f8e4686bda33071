"""Drives to the start, predicted from published ones: more robots take longer, nine in ten fit."""

import pytest

from posflock_robotarium.verify.initial_drive_time import PUBLISHED, predicted_drive


def test_nine_drives_of_ten_fall_into_the_interval_that_the_others_predict():
    inside = 0
    for left_out, (robots, seconds) in enumerate(PUBLISHED):
        others = PUBLISHED[:left_out] + PUBLISHED[left_out + 1 :]
        drive = predicted_drive(robots, published=others)
        inside += drive.least <= seconds <= drive.most
    assert inside >= 0.9 * len(PUBLISHED)


@pytest.mark.parametrize("robots", [1, 9, 20])
def test_more_robots_take_longer(robots):
    fewer, more = predicted_drive(robots), predicted_drive(robots + 1)
    assert 0.0 < fewer.least < fewer.median < fewer.most
    assert more.median > fewer.median


def test_no_drive_is_faster_than_the_simulated_one():
    free = predicted_drive(9)
    assert predicted_drive(9, 5.0) == free
    slow = predicted_drive(9, 60.0)
    assert (slow.least, slow.median, slow.most) == (60.0, 60.0, free.most)
