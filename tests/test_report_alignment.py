"""Whether a flock aligned is answered rightly, for flocks that move, stand, stop and scatter."""

import dataclasses

import numpy as np
import pytest
from judged_runs import pair, parked, verdict

from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.alignment.verdicts import headline
from posflock_robotarium.report import Run, analyse


@pytest.mark.parametrize("noise", [0.0, 0.0005])
def test_a_parked_flock_is_said_to_stand_however_parallel_its_headings(noise):
    analysis = parked(noise)
    aligned = verdict(analysis, "align")
    assert analysis.numbers["gamma_headings"].value > 0.999
    assert aligned.mark == "bad"
    assert aligned.answer == "No: nothing moves."
    assert "Headings are parallel (γ from headings 1.000)" in aligned.because
    assert "not flocking" in aligned.because
    assert headline(analysis.verdicts).startswith("parked")
    assert verdict(analysis, "sure").mark == "caution"


def test_one_robot_of_many_that_stands_is_told():
    moving = known_flock("parallel", 0.1, robots=20, position_noise=0).recording
    poses = moving.poses.copy()
    poses[:, :, 3] = poses[0, :, 3]
    analysis = analyse(dataclasses.replace(moving, poses=poses), radius=100.0)
    assert analysis.numbers["robots_standing"].value == 1
    assert verdict(analysis, "align").answer == "Those that moved did."
    assert "1 of 20 robots stood over half the time." in verdict(analysis, "align").because


def test_a_flock_that_parks_on_the_way_came_to_a_stop():
    moving = known_flock("parallel", 0.1, duration=70.0, position_noise=0).recording
    poses = moving.poses.copy()
    poses[len(poses) * 3 // 4 :] = poses[len(poses) * 3 // 4]
    analysis = analyse(dataclasses.replace(moving, poses=poses), radius=100.0)
    assert verdict(analysis, "align").answer == "No: it came to a stop."
    assert verdict(analysis, "align").mark == "bad"


def test_a_flock_that_stops_at_the_very_end_has_flocked():
    moving = known_flock("parallel", 0.1, duration=70.0, position_noise=0).recording
    poses = moving.poses.copy()
    poses[-60:] = poses[-60]
    analysis = analyse(dataclasses.replace(moving, poses=poses), radius=100.0)
    assert verdict(analysis, "align").mark == "good"


def test_verdicts_tell_parallel_from_scattered():
    answers = {}
    for motion in ("parallel", "counter", "random"):
        flock = known_flock(motion, 0.1)
        answers[motion] = verdict(analyse(flock.recording, radius=flock.radius), "align").mark
    assert answers == {"parallel": "good", "counter": "bad", "random": "bad"}


def test_parallel_headings_with_scattered_motion_are_not_alignment():
    flock = known_flock("random", 0.1)
    poses = flock.recording.poses.copy()
    poses[:, 2] = 0.7
    analysis = analyse(dataclasses.replace(flock.recording, poses=poses), radius=100.0)
    assert verdict(analysis, "align").answer == "No: headings are parallel, motion is not."
    assert "headings and motion disagree" in verdict(analysis, "sure").answer


def rotation(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def test_headings_in_degrees_are_noticed():
    flock = known_flock("random", 0.1)
    poses = flock.recording.poses.copy()
    poses[:, 2] = np.degrees(poses[:, 2])
    analysis = analyse(dataclasses.replace(flock.recording, poses=poses), radius=100.0)
    assert verdict(analysis, "sure").mark == "bad"
    assert "degrees" in verdict(analysis, "sure").answer


def test_degrees_that_happen_to_lie_along_the_motion_are_noticed():
    moving = known_flock("parallel", 0.1, robots=4).recording
    course = np.arctan2(*(moving.poses[-1, 1::-1, 0] - moving.poses[0, 1::-1, 0]))
    poses = moving.poses.copy()
    poses[:, :2] = rotation(np.radians(70.0) - course) @ poses[:, :2]
    poses[:, 2] = 70.0  # which is 51 degrees as an angle in radians
    analysis = analyse(dataclasses.replace(moving, poses=poses), radius=100.0)
    assert 0.15 < analysis.numbers["heading_offset"].value < 0.35
    assert "degrees" in verdict(analysis, "sure").answer


def test_headings_that_count_whole_turns_are_radians():
    moving = known_flock("parallel", 0.1, robots=4).recording
    poses = moving.poses + np.array([[0.0], [0.0], [6 * np.pi]])
    analysis = analyse(dataclasses.replace(moving, poses=poses), radius=100.0)
    assert verdict(analysis, "sure").mark == "good"


def test_alignment_for_good_is_later_than_alignment_for_once():
    t = np.arange(300) * 0.033
    poses = np.zeros((300, 3, 2))
    poses[:, 0, 0] = poses[:, 0, 1] = 0.1 * t
    poses[:, 1, 1] = 0.3
    poses[:, 2, 1] = np.interp(np.arange(300), [99, 110, 139, 150], [0, 2, 2, 0])
    numbers = analyse(Run("wobble", t, poses), radius=0.75).numbers
    assert numbers["time_to_alignment_headings"].value == 0
    below = np.flatnonzero(np.cos(poses[:, 2, 1]) < 0.9)
    assert numbers["time_aligned_for_good_headings"].value == pytest.approx(t[below[-1] + 1])
    assert numbers["share_aligned_headings"].value == pytest.approx(1 - len(below) / 300)


def test_one_robot_is_analysed_without_alignment():
    recording = pair(np.full(120, 0.3))
    alone = dataclasses.replace(recording, poses=recording.poses[:, :, :1])
    analysis = analyse(alone, radius=0.75)
    assert np.isnan(analysis.numbers["gamma_motion"].value)
    assert verdict(analysis, "align").mark == "unknown"


def test_three_frames_do_not_tell_whether_a_flock_aligned():
    flock = known_flock("parallel", 0.1, duration=2.0)
    short = dataclasses.replace(
        flock.recording, t=flock.recording.t[:3], poses=flock.recording.poses[:3]
    )
    answer = verdict(analyse(short, radius=flock.radius), "align")
    assert (answer.mark, answer.answer) == ("unknown", "Too short to tell.")
