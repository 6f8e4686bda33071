"""What a report says of collisions, walls, limits and the certificate; the rest is unknown."""

import dataclasses

import numpy as np
import pytest
from judged_runs import pair, parked, verdict

from posflock_robotarium.report import analyse


def test_collisions_are_counted_by_the_testbeds_own_test():
    distance = np.full(120, 0.3)
    for rows, least in ((slice(20, 30), 0.13), (slice(60, 62), 0.134), (slice(90, 91), 0.136)):
        away = np.maximum(rows.start - np.arange(120), np.arange(120) - rows.stop + 1).clip(0)
        distance = np.minimum(distance, least + 0.015 * away)  # no faster than wheels turn
    analysis = analyse(pair(distance), radius=0.75)
    assert analysis.numbers["collisions"].value == 2
    assert analysis.numbers["collision_steps"].value == 12
    assert [(e.first, e.last, e.robots) for e in analysis.events] == [
        (20, 29, (0, 1)),
        (60, 61, (0, 1)),
    ]
    assert verdict(analysis, "safe").answer == "No: 2 collisions."


def test_the_collision_points_lie_ahead_of_the_centres():
    # Centres .18 apart along x, nose to nose: the points .025 ahead are .13 apart.
    recording = pair(np.zeros(120), heading=(0.0, np.pi))
    poses = recording.poses.copy()
    poses[:, 0] = [[0.0, 0.18]]
    analysis = analyse(dataclasses.replace(recording, poses=poses), radius=0.75)
    assert analysis.numbers["smallest_distance"].value == pytest.approx(0.18)
    assert analysis.numbers["smallest_collision_distance"].value == pytest.approx(0.13)
    assert analysis.numbers["collisions"].value == 1


def test_leaving_the_arena_is_an_event_and_a_verdict():
    recording = pair(np.full(120, 0.3))
    poses = recording.poses.copy()
    poses[:, 0, 1] = np.interp(
        np.arange(120), [0, 39, 43, 46, 50, 119], [1.2, 1.595, 1.65, 1.65, 1.595, 1.2]
    )
    analysis = analyse(dataclasses.replace(recording, poses=poses), radius=0.75)
    assert analysis.numbers["boundary_events"].value == 1
    assert analysis.numbers["boundary_steps"].value == 10
    assert analysis.numbers["smallest_wall_distance"].value == pytest.approx(-0.05)
    assert verdict(analysis, "safe").answer == "No: 1 boundary crossing."


def test_stalls_and_wheel_excess_come_from_the_commands():
    recording = pair(np.full(120, 0.3))
    poses = recording.poses.copy()
    poses[60:, :, 1] = poses[60, :, 1]
    command = np.zeros((120, 2, 2))
    command[:, 0] = 0.1
    command[5, 0, 0] = 0.3
    analysis = analyse(dataclasses.replace(recording, poses=poses, commands=command), radius=0.75)
    assert analysis.numbers["stalls"].value == 1
    assert analysis.numbers["wheel_excess_steps"].value == 1
    assert analysis.numbers["wheel_excess"].value == pytest.approx(0.3 / 0.016 - 12.5)
    assert verdict(analysis, "limits").mark == "bad"


def test_without_commands_limits_are_unknown():
    assert verdict(parked(), "limits").mark == "unknown"


def test_the_certificates_interventions_are_counted():
    recording = dataclasses.replace(
        pair(np.full(120, 0.3)),
        commands=np.zeros((120, 2, 2)),
        intervention=np.where(np.arange(120) < 30, 0.02, 0.0),
        clearance=np.linspace(0.1, 0.01, 120),
        status=np.array(["relaxed"] * 3 + ["optimal"] * 117),
    )
    numbers = analyse(recording, radius=0.75).numbers
    assert numbers["interventions"].value == 0.25
    assert numbers["intervention_mean"].value == pytest.approx(0.02)
    assert numbers["clearance"].value == pytest.approx(0.01)
    assert numbers["unsolved"].value == 3


def test_an_unsafe_start_is_said_with_the_safety():
    recording = dataclasses.replace(
        pair(np.full(120, 0.3)), clearance=np.linspace(-0.02, 0.01, 120)
    )
    analysis = analyse(recording, radius=0.75)
    assert analysis.numbers["clearance_first"].value == pytest.approx(-0.02)
    assert "It started 20 mm closer than the certificate keeps" in verdict(analysis, "safe").because


def test_a_log_without_a_certificate_says_nothing_of_one():
    nothing = np.full(120, np.nan)
    recording = dataclasses.replace(
        pair(np.full(120, 0.3)),
        intervention=nothing,
        clearance=nothing,
        status=np.full(120, ""),
    )
    numbers = analyse(recording, radius=0.75).numbers
    assert not {"interventions", "clearance", "clearance_first", "unsolved"} & set(numbers)


def test_a_flock_that_parts_is_not_together():
    distance = np.linspace(0.3, 1.2, 120)
    analysis = analyse(pair(distance), radius=0.75)
    assert analysis.numbers["components"].value == 2
    assert analysis.numbers["connected"].value == pytest.approx((distance < 0.75).mean())
    assert verdict(analysis, "together").mark == "bad"


def test_a_killed_run_is_not_the_whole_run():
    analysis = parked(parameters={"ended": {"how": "running"}, "duration": 120.0})
    assert verdict(analysis, "whole run").mark == "caution"
    assert "60.0 s are logged of 120.0 s planned" in verdict(analysis, "whole run").because
