"""The published certificates answer the exact optimum of their rows."""

import warnings

import numpy as np
from dense_program import (
    ARENA,
    AROUND,
    Program,
    Wheels,
    ahead,
    check,
    clipped,
    teams,
    to_command,
    to_point,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from rps_compat import deviations
from rps_compat.v1.utilities import barrier_certificates as first
from rps_compat.v1.utilities import barrier_certificates2 as older
from rps_compat.v2.utilities import barrier_certificates as second


@given(teams(), st.sampled_from([0.13, 0.2]), st.sampled_from([30, 100.0]))
@settings(max_examples=25)
def test_single_integrators_of_generation_1(team, radius, gain):
    poses, velocities, _ = team
    x = poses[:2].copy()
    program = Program(x, clipped(velocities, 0.15)).pairs(radius, gain)
    certificate = first.create_single_integrator_barrier_certificate(gain, radius, 0.15)
    check(lambda: certificate(velocities, x), program)
    walled = first.create_single_integrator_barrier_certificate_with_boundary(gain, radius, 0.15)
    check(lambda: walled(velocities, x), program.walls(ARENA, radius, gain))
    parting = first.create_single_integrator_barrier_certificate2(gain, 1e4, radius, 0.15)
    program = Program(x, clipped(velocities, 0.15)).pairs(radius, gain, 1e4)
    check(lambda: parting(velocities, x), program, tolerance=1e-5)


@given(teams())
@settings(max_examples=25)
def test_unicycles_of_generation_1(team):
    poses, velocities, turns = team
    commands = np.vstack([velocities[0], turns])
    points = ahead(poses, 0.05)
    wanted = clipped(to_point(commands, poses, 0.05), 0.12)

    def command(v):
        v, w = to_command(v, poses, 0.05)
        return np.array([v, np.clip(w, -np.pi, np.pi)])

    program = Program(points, wanted).pairs(0.15 + 0.05, 80)
    plain = first.create_unicycle_barrier_certificate(80, 0.15, 0.05, 0.12)
    check(lambda: plain(commands, poses), program, command, 1e-4)
    walled = first.create_unicycle_barrier_certificate_with_boundary(80, 0.15, 0.05, 0.12)
    check(lambda: walled(commands, poses), program.walls(ARENA, 0.2, 80), command, 1e-4)


@given(teams())
@settings(max_examples=25)
def test_wheels_of_generation_1(team):
    poses, velocities, turns = team
    commands = np.vstack([velocities[0], turns])
    wheels = Wheels(poses, 0.05)
    obstacles = np.array([[0.5, -0.4], [0.1, -0.6]])

    def program():
        wanted = to_point(commands, poses, 0.05)
        return (
            Program(ahead(poses, 0.05), wanted)
            .pairs(0.14, 150, loss=wheels.loss(3))
            .wheels(wheels.inverse, 12.5)
        )

    def command(v):
        return to_command(v, poses, 0.05)

    settings_ = {"disturbance": 3, "safety_radius": 0.14}
    free = first.create_unicycle_differential_drive_barrier_certificate(**settings_)
    check(lambda: free(commands, poses), program(), command, 1e-4)
    walled = first.create_unicycle_differential_drive_barrier_certificate_with_boundary(**settings_)
    with_walls = program().walls(ARENA, 0.14, 150)
    check(lambda: walled(commands, poses), with_walls, command, 1e-4)
    robust = older.create_robust_barriers(d=3, safety_radius=0.14)
    with_obstacles = program().obstacles(obstacles, 0.14, 150, wheels.loss(3))
    check(lambda: robust(commands, poses, obstacles), with_obstacles, command, 1e-4)
    check(lambda: free(commands, poses, obstacles), with_obstacles, command, 1e-4)


@given(teams(), st.booleans())
@settings(max_examples=25)
def test_single_integrators_of_generation_2(team, published):
    poses, velocities, _ = team
    with deviations.all_as_published(published):
        plain = second.create_si_barrier_certificate(0.18, 60.0, 0.15)
        program = Program(poses[:2], velocities).pairs(0.18, 60)
        check(lambda: plain(velocities, poses), program.octagon(0.15, 0.15 if published else None))
        walled = second.create_si_barrier_certificate_with_boundary(0.18, 60.0, 0.15)
        program = Program(poses[:2], velocities).pairs(0.18, 60).octagon(0.15)
        check(lambda: walled(velocities, poses), program.walls(AROUND, 0.18, 60))


@given(teams())
@settings(max_examples=25)
def test_unicycles_of_generation_2(team):
    poses, velocities, turns = team
    commands = np.vstack([velocities[0], turns])

    def program(distance, radius, gain):
        wanted = to_point(commands, poses, distance)
        return Program(ahead(poses, distance), wanted).pairs(radius, gain).octagon(0.2)

    plain = second.create_uni_barrier_certificate()
    check(
        lambda: plain(commands, poses),
        program(0.05, 0.25, 100),
        lambda v: to_command(v, poses, 0.05),
        1e-4,
    )
    walled = second.create_uni_barrier_certificate_with_boundary()
    obstacles = np.array([[0.3], [0.2]])
    check(
        lambda: walled(commands, poses, obstacles),
        program(0.03, 0.18, 150)
        .walls(ARENA, 0.18, 150)
        .obstacles(obstacles, 0.18, 150, lambda *_: 0),
        lambda v: to_command(v, poses, 0.03),
        1e-4,
    )


def test_fifty_robots_get_the_answer_of_all_their_rows():
    rng = np.random.default_rng(8)
    grid = np.array([(i % 10, i // 10) for i in range(50)]).T * [[0.3], [0.36]] - [[1.35], [0.72]]
    x, velocities = grid + rng.normal(0, 0.03, grid.shape), rng.normal(0, 0.2, (2, 50))
    program = Program(x, velocities).pairs(0.15, 100).octagon(0.2).walls(AROUND, 0.15, 100)
    certificate = second.create_si_barrier_certificate_with_boundary()
    check(lambda: certificate(velocities, x), program)


def test_robots_may_have_to_part_faster_than_any_robot():
    rng = np.random.default_rng(4)
    x = rng.uniform(-0.3, 0.3, (2, 12))
    velocities = rng.normal(0, 0.1, (2, 12))
    certificate = first.create_single_integrator_barrier_certificate2()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", "the first call of a certificate")
        safe = certificate(velocities, x)
    assert np.abs(safe).max() > 100
    optimum = Program(x, clipped(velocities, 0.2)).pairs(0.17, 100, 1e6).solve()
    np.testing.assert_allclose(safe, optimum, atol=1e-4, rtol=1e-6)
