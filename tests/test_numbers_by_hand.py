"""Numbers of a report's summary for small flocks, of which they are known beforehand."""

import math

import numpy as np
import pytest

from posflock_robotarium.report import AnalysisOptions, Run, analyse


@pytest.mark.parametrize(("stand", "stalls"), [(12, 0), (13, 1)])
def test_a_stall_is_longer_than_a_second_at_the_slowest_command_that_drives(stand, stalls):
    """Exactly a second is none; a command of exactly 0.02 m/s counts."""
    t = 0.1 * np.arange(60)
    moved = np.full(60, 0.01)
    moved[20 : 20 + stand] = 0.0
    poses, commands = np.zeros((60, 3, 2)), np.zeros((60, 2, 2))
    poses[:, 0] = np.cumsum(moved)[:, None]
    poses[:, 1] = [0.0, 0.4]
    commands[:, 0, 0] = 0.02  # the other robot is told to stand
    run = Run("short", t, poses, commands)
    numbers = analyse(run, AnalysisOptions(radius=1.0, window=0.3)).numbers
    assert numbers["stalls"].value == stalls
    assert numbers["stall_time"].value == pytest.approx(1.1 * stalls)


def test_the_offset_of_headings_is_that_of_robots_that_move():
    t = 0.033 * np.arange(100)
    poses = np.zeros((100, 3, 2))
    poses[:, 0] = np.array([0.1, 0.03]) * t[:, None]
    poses[:, 1] = [0.0, 0.4]
    poses[:, 2] = [0.2, 1.0]  # the slow one drifts sideways
    run = Run("drift", t, poses)
    for slowest, offset, moving in ((0.02, 0.6, 2), (0.05, 0.2, 1), (0.2, math.nan, 0)):
        found = analyse(run, AnalysisOptions(radius=1.0, slowest=slowest)).numbers
        assert found["heading_offset"].value == pytest.approx(offset, nan_ok=True)
        # γ wants two that move, polarisation one.
        assert found["left_out_motion"].value == (0.0 if moving == 2 else 1.0)
        polarised = found["polarisation_motion"].value
        assert polarised == pytest.approx(1.0 if moving else math.nan, nan_ok=True)
        assert found["standing"].value == 1.0 - moving / 2


@pytest.mark.parametrize("offset", [0.4, -0.4, 1.2])
@pytest.mark.parametrize("backwards", [False, True])
def test_headings_that_point_elsewhere_show_by_how_much(offset, backwards):
    t = 0.033 * np.arange(400)
    poses = np.zeros((400, 3, 3))
    direction = np.array([0.3, 2.0, -2.5])
    way = (-0.1 if backwards else 0.1) * t[:, None]
    poses[:, 0], poses[:, 1] = way * np.cos(direction), way * np.sin(direction)
    poses[:, 1] += [0.0, 1.0, 2.0]
    poses[:, 2] = direction + offset
    found = analyse(Run("turned", t, poses), radius=1.0).numbers["heading_offset"].value
    assert found == pytest.approx(abs(offset))  # of a line: driving backwards is no offset


@pytest.mark.parametrize("samples", [8, 10, 11, 12])
def test_a_log_shorter_than_ten_steps_has_an_offset_too(samples):
    poses = np.zeros((samples, 3, 2))
    poses[:, 0] = 0.02 * np.arange(samples)[:, None]
    poses[:, 1] = [0.0, 0.4]
    poses[:, 2] = 0.3
    numbers = analyse(Run("short", 0.1 * np.arange(samples), poses), radius=1.0).numbers
    assert numbers["heading_offset"].value == pytest.approx(0.3)


def test_headings_that_are_wrong_for_a_while_or_across_gaps_do_not_count():
    t = 0.033 * np.arange(450)
    t += 5.0 * (np.arange(450) // 15)  # after every 15 samples a gap
    poses = np.zeros((450, 3, 2))
    poses[:, 0] = 0.1 * 0.033 * (np.arange(450) % 15)[:, None]
    poses[:, 1] = 0.1 * (np.arange(450) // 15 % 2)[:, None] + np.array([0.0, 0.4])  # moved aside
    poses[:, 2] = 0.3
    poses[:100, 2] = 1.5
    found = analyse(Run("gaps", t, poses), radius=1.0).numbers
    assert found["heading_offset"].value == pytest.approx(0.3)


def test_a_flock_that_stands_has_no_alignment_by_motion():
    poses = np.zeros((100, 3, 3))
    poses[:, 0] = [-0.5, 0.0, 0.5]
    still = analyse(Run("still", 0.033 * np.arange(100), poses), radius=1.0).numbers
    for key in ("gamma_motion", "polarisation_motion", "heading_offset", "noise_course"):
        assert math.isnan(still[key].value), key
    assert still["gamma_headings"].value == pytest.approx(1.0)
    assert still["left_out_motion"].value == still["standing"].value == 1.0
    assert still["robots_standing"].value == 3
    assert still["heading_spread"].value == pytest.approx(0.0)
    assert still["gap_time"].value == still["gaps"].value == 0
    for threshold in (0.9, -0.5):
        options = AnalysisOptions(radius=1.0, threshold=threshold)
        numbers = analyse(Run("still", 0.033 * np.arange(100), poses), options).numbers
        assert numbers["share_aligned_motion"].value == 0.0
        assert math.isnan(numbers["time_to_alignment_motion"].value)


def test_at_the_threshold_is_aligned_and_at_the_slowest_speed_is_standing():
    t = 0.1 * np.arange(60)
    poses = np.zeros((60, 3, 2))
    poses[:, 0] = 0.02 * t[:, None]
    poses[:, 1] = [0.0, 0.4]
    options = AnalysisOptions(radius=1.0, threshold=1.0, slowest=0.02, window=0.5)
    numbers = analyse(Run("slow", t, poses), options).numbers
    assert numbers["share_aligned_headings"].value == 1.0
    assert numbers["standing"].value == 1.0
    assert numbers["robots_standing"].value == 2
    # Two robots are a pair.
    for key in ("nearest_neighbour", "smallest_distance", "smallest_collision_distance"):
        assert numbers[key].value == pytest.approx(0.4)
    assert numbers["collisions"].value == numbers["collision_steps"].value == 0
    assert numbers["components"].value == numbers["connected"].value == 1
    assert numbers["algebraic_connectivity"].value == pytest.approx(2.0)


def test_headings_without_a_common_direction_have_no_spread():
    poses = np.zeros((60, 3, 2))
    poses[:, 1] = [0.0, 0.4]
    poses[:, 2] = [0.3, 0.3 + np.pi]
    numbers = analyse(Run("opposed", 0.1 * np.arange(60), poses), radius=1.0).numbers
    assert math.isnan(numbers["heading_spread"].value)
    assert numbers["polarisation_headings"].value == pytest.approx(0.0)


@pytest.mark.parametrize(("moving", "defined"), [(5, False), (12, True)])
def test_gamma_rests_on_half_a_percent_of_robots_and_time_at_least(moving, defined):
    """Two of two robots that move together for so many of 2000 samples."""
    t = 0.033 * np.arange(2000)
    speed = np.zeros(2000)
    speed[1000 : 1000 + moving] = 0.5
    poses = np.zeros((2000, 3, 2))
    poses[:, 0] = (0.033 * np.cumsum(speed))[:, None]
    poses[:, 1] = [0.0, 0.3]
    options = AnalysisOptions(radius=1.0, window=0.1, transient=0.0)
    numbers = analyse(Run("brief", t, poses), options).numbers
    counted = 1.0 - numbers["left_out_motion"].value
    assert (counted >= 0.005) == defined
    assert math.isfinite(numbers["gamma_motion"].value) == defined


def test_a_robot_alone_has_no_neighbours_and_nobody_to_collide_with():
    t = 0.033 * np.arange(60)
    poses = np.zeros((60, 3, 1))
    poses[:, 0, 0] = 0.1 * t
    alone = analyse(Run("alone", t, poses), radius=1.0).numbers
    assert not {"components", "connected", "collisions", "nearest_neighbour"} & alone.keys()
    assert math.isnan(alone["cohesive_radius_ratio"].value)
    assert alone["smallest_wall_distance"].value == pytest.approx(1.0)
    assert alone["speed"].value == pytest.approx(0.1)
