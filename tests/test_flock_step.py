"""Every step of the flock is the one that its module describes, written down a second time."""

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from barrier_certificates.guarantee import largest_gain, largest_wall_gain
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.flock import EXPERIMENT_CERTIFICATE, WALLS, Flock
from posflock_robotarium.flocking.law import (
    LawParameters,
    displacements,
    position_based_input,
    saturate,
)
from posflock_robotarium.flocking.pose_filter import PoseFilterParameters
from posflock_robotarium.flocking.steering import ArenaSteering, SteeringParameters
from rps_compat.arena import Arena

LAW = LawParameters(
    distance_scale=0.15, radius=0.6, persistence=0.4, speed_limit=0.14, input_limit=0.4
)
STEP = 0.04
ARENA = (-0.8, 0.9, -0.6, 0.7)
CERTIFICATE = replace(EXPERIMENT_CERTIFICATE, boundary=ARENA, projection_distance=0.06)
STEERING = SteeringParameters(start=0.5, reach=0.25)
START = np.array([
    [-0.4, 0.0, 0.45, -0.3, 0.4],
    [-0.3, -0.35, -0.1, 0.2, 0.3],
    [0.3, 1.2, -0.4, 2.8, -2.0],
])  # fmt: skip


def flock_of(**changes):
    chosen = {"certificate": CERTIFICATE, "steering": STEERING, "neighbour_hysteresis": 0.0}
    return Flock(LAW, STEP, **(chosen | changes))


class Reference:
    """The six points of the module's docstring, in the ideal arena."""

    def __init__(self, walls):
        self.walls = walls
        self.certificate = replace(CERTIFICATE, time_step=STEP)
        self.steering = ArenaSteering(STEERING, ARENA, CERTIFICATE.wall_margin, STEP)
        self.k, self.imprint, self.velocity = 0, None, np.zeros((2, 5))

    def step(self, poses):
        e = np.array([np.cos(poses[2]), np.sin(poses[2])])
        q = poses[:2] + 0.06 * e
        if self.imprint is None:
            self.imprint = displacements(q)
        self.k += 1
        u = saturate(position_based_input(q, self.imprint, self.k * STEP, LAW), 0.4)
        w, turning = self.velocity, 0.0
        if self.walls == "steer":
            u, w, turning = self.steering.steer(self.k * STEP, q, u, w)
        w = saturate(w + STEP * u, 0.14)
        # Scaled until no limit of the motors is broken, each robot for itself, direction kept.
        limits = self.certificate.polygon()
        for i in range(5):
            body = np.array([e[:, i] @ w[:, i], -e[1, i] * w[0, i] + e[0, i] * w[1, i]])
            over = max(
                normal @ body / b for normal, b in zip(limits.normals.T, limits.bounds, strict=True)
            )
            w[:, i] /= max(1.0, over)
        self.velocity, info = self.certificate.project(w, poses)
        return self.certificate.commands(self.velocity, poses), info, turning


@pytest.mark.parametrize("walls", WALLS)
def test_the_flock_does_what_its_docstring_says_step_by_step(walls):
    flock, reference, arena = flock_of(walls=walls), Reference(walls), Arena(START)
    arena.robot = replace(arena.robot, time_step=STEP, boundaries=ARENA)
    bound = turned = 0
    for _ in range(150):
        decision = flock.step(arena.poses)
        command, info, turning = reference.step(arena.poses.copy())
        assert_allclose(decision.command, command, atol=1e-9)
        assert (decision.status, decision.active) == (info.status, info.active)
        assert decision.intervention == pytest.approx(info.intervention, abs=1e-9)
        assert decision.clearance == pytest.approx(info.clearance, abs=1e-9)
        assert decision.turning == turning
        bound += info.status == "optimal"
        turned += turning != 0.0
        arena.commands = decision.command
        arena.step()
    assert (bound > 20) == (walls == "certificate")  # steering keeps it from having to
    assert (turned > 20) == (walls == "steer")


def test_the_log_of_a_step_is_what_was_decided():
    decision = flock_of().step(START)
    assert decision.logged() == {
        "command": decision.command,
        "status": decision.status,
        "intervention": decision.intervention,
        "clearance": decision.clearance,
    }


def test_a_flock_without_pair_rows_says_how_near_robots_are_and_lets_them():
    near = np.array([[0.0, 0.18], [0.0, 0.0], [0.0, np.pi]])
    control = flock_of(certificate=replace(CERTIFICATE, pair_rows=False))
    decision = control.step(near)
    assert decision.clearance == pytest.approx(0.18 - 2 * 0.06 - 0.2)
    assert decision.active == ()
    apart = np.array([[-0.5, 0.7], [0.0, 0.0], [0.0, 0.0]])  # the wall at 0.9 is what is near
    control.reset()
    assert control.step(apart).clearance == pytest.approx(0.9 - 0.7 - 0.06 - 0.11)
    # In the middle of a wide arena nothing is near, and that is known, too.
    wide = replace(CERTIFICATE, pair_rows=False, boundary=(-3.0, 3.0, -3.0, 3.0))
    alone = np.array([[-0.1, 0.5], [0.0, 0.0], [0.0, 0.0]])
    assert flock_of(certificate=wide).step(alone).clearance == pytest.approx(0.6 - 0.2)


def test_late_robots_are_seen_where_they_were_sent():
    """Where tracking disagrees with the commands, a share `rate` a second of it is believed."""
    flock = flock_of(filtering=PoseFilterParameters(rate=2.0))
    first = flock.step(START).command
    stuck = flock.step(START).command  # they did not move at all
    poses = START + STEP * np.array([
        first[0] * np.cos(START[2]), first[0] * np.sin(START[2]), first[1]
    ])  # fmt: skip
    believed = poses + 2.0 * STEP * (START - poses)
    obedient = flock_of(filtering=PoseFilterParameters(rate=1.0 / STEP))
    obedient.step(START)
    assert_allclose(obedient.step(believed).command, stuck, atol=1e-12)
    assert not np.allclose(first, stuck, atol=1e-3)


def test_everything_that_a_run_needs_is_told():
    flock = flock_of(walls="steer", filtering=PoseFilterParameters(rate=2.0))
    told = flock.parameters()
    assert told["law"] == {
        "distance_scale": 0.15,
        "radius": 0.6,
        "persistence": 0.4,
        "speed_limit": 0.14,
        "input_limit": 0.4,
    }
    assert (told["time_step"], told["walls"]) == (STEP, "steer")
    assert told["wheels"]["boundary"] == ARENA
    assert told["wheels"]["time_step"] == STEP
    assert told["steering"]["reach"] == 0.25
    assert told["filtering"]["rate"] == 2.0
    assert (told["neighbour_radius"], told["neighbour_hysteresis"]) == (0.6, 0.0)
    assert told["arena"] == list(ARENA)
    assert flock_of(walls="certificate").parameters()["steering"] is None


def test_the_papers_experiment_is_what_nobody_asks_otherwise():
    """Values that the acceptance table and the documentation rest on."""
    told = Flock().parameters()
    assert told["law"] == {
        "distance_scale": 0.12,
        "radius": 0.75,
        "persistence": 0.15,
        "speed_limit": 0.15,
        "input_limit": 0.5,
    }
    assert (told["time_step"], told["walls"], told["neighbour_hysteresis"]) == (
        0.033,
        "steer",
        0.15,
    )
    assert told["steering"] == {"start": 3.0, "reach": 0.18, "turn_rate": 0.45, "clear": 0.2}
    wheels = {name: told["wheels"][name] for name in (
        "safety_radius", "barrier_gain", "wall_gain", "boundary", "wall_margin", "speed_limit",
        "turn_rate_limit", "projection_distance", "wheel_limit", "pair_rows")}  # fmt: skip
    assert wheels == {
        "safety_radius": 0.20,
        "barrier_gain": 2000.0,
        "wall_gain": 100.0,
        "boundary": (-1.6, 1.6, -1.0, 1.0),
        "wall_margin": 0.11,
        "speed_limit": 0.15,
        "turn_rate_limit": 0.55,
        "projection_distance": 0.05,
        "wheel_limit": 12.5,
        "pair_rows": True,
    }


@pytest.mark.parametrize(
    ("seconds", "steps"), [(0.02, 1), (0.04, 1), (0.0601, 2), (0.1, 3), (120.0, 3000)]
)
def test_a_duration_is_a_whole_number_of_steps(seconds, steps):
    assert flock_of().steps_in(seconds) == steps


@pytest.mark.parametrize("seconds", [0.0199, 0.0, -1.0, math.nan, math.inf])
def test_a_duration_that_is_no_step_is_refused(seconds):
    with pytest.raises(ParameterError, match=r"duration: expected at least one step of 0\.04 s"):
        flock_of().steps_in(seconds)


@pytest.mark.parametrize("step", [0.0, -0.033, math.nan, math.inf])
def test_time_steps_that_are_none_are_refused(step):
    with pytest.raises(ParameterError, match="time_step: expected more than 0 s"):
        Flock(LAW, step)


def test_gains_may_be_as_large_as_the_time_step_admits_and_no_larger():
    speed = replace(CERTIFICATE, time_step=STEP).polygon().top_speed()
    pairs, walls = largest_gain(0.20, speed, STEP), largest_wall_gain(speed, STEP)
    flock_of(certificate=replace(CERTIFICATE, barrier_gain=pairs, wall_gain=walls))
    with pytest.raises(ParameterError, match="certificate: barrier_gain is"):
        flock_of(certificate=replace(CERTIFICATE, barrier_gain=1.001 * pairs))
    with pytest.raises(ParameterError, match="certificate: wall_gain is"):
        flock_of(certificate=replace(CERTIFICATE, wall_gain=1.001 * walls))
    # Without one of its own, a wall has the gain of the pairs.
    flock_of(certificate=replace(CERTIFICATE, barrier_gain=pairs, wall_gain=None))


@pytest.mark.parametrize(
    "wrong", [{"boundary": None}, {"wall_margin": None}, {"boundary": [(0, 1, 0), (0, 0, 1)]}]
)
def test_an_arena_to_steer_in_is_a_rectangle_with_a_margin(wrong):
    with pytest.raises(ParameterError, match="certificate: expected a boundary"):
        flock_of(certificate=replace(CERTIFICATE, **wrong))


def test_either_limit_of_the_motors_is_enough():
    for left in ("speed_limit", "wheel_limit"):
        flock_of(certificate=replace(CERTIFICATE, **{left: None}))
    with pytest.raises(ParameterError, match="expected a speed_limit or a wheel_limit"):
        flock_of(certificate=replace(CERTIFICATE, speed_limit=None, wheel_limit=None))


@pytest.mark.parametrize(
    ("poses", "words"),
    [
        (np.zeros((3, 1)), "at least two robots"),
        (np.zeros((2, 5)), r"got \(2, 5\)"),
        (np.zeros(3), r"got \(3,\)"),
        (np.zeros((1, 3, 5)), r"got \(1, 3, 5\)"),
        ("here", "got 'here'"),
        (START * [[1], [1], [math.inf]], "got θ = inf of robot 0"),
    ],
)
def test_poses_that_are_none_are_refused(poses, words):
    with pytest.raises(ParameterError, match=words):
        flock_of().step(poses)


def test_two_robots_are_a_flock_and_their_number_stays():
    flock = flock_of()
    assert flock.step(START[:, :2]).command.shape == (2, 2)
    with pytest.raises(ParameterError, match="expected 2 robots as at the first step, got 5"):
        flock.step(START)
    flock.reset()
    flock.step(START)


def test_a_reset_forgets_imprint_velocity_time_links_filter_and_certificate():
    flock, arena = flock_of(neighbour_hysteresis=0.2), Arena(START)
    for _ in range(60):
        arena.commands = flock.step(arena.poses).command
        arena.step()
    flock.reset()
    fresh, again = flock_of(neighbour_hysteresis=0.2), Arena(START)
    for _ in range(60):
        command = fresh.step(again.poses).command
        assert np.array_equal(flock.step(again.poses).command, command)
        again.commands = command
        again.step()


def test_an_unsafe_start_is_warned_of_where_the_flock_is_called():
    near = np.array([[0.0, 0.25], [0.0, 0.0], [0.0, np.pi]])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        flock_of().step(near)
    (warning,) = caught
    assert "robots 0 and 1 start 70 mm closer than the certificate keeps them" in str(
        warning.message
    )
    assert warning.filename == __file__


def test_a_second_run_of_a_flock_is_warned_of_an_unsafe_start_again():
    near = np.array([[0.0, 0.25], [0.0, 0.0], [0.0, np.pi]])
    flock = flock_of()
    with pytest.warns(UserWarning, match="start 70 mm closer"):
        flock.step(near)
    flock.step(near)
    flock.reset()
    with pytest.warns(UserWarning, match="start 70 mm closer"):
        flock.step(near)
