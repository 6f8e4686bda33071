"""Everything that the published packages bring can be imported, by its names."""

import importlib
import inspect
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rps_compat
from rps_compat.errors import CommandError
from rps_compat.v1.utilities import uni_ekf as first_ekf
from rps_compat.v2.examples.state_estimation.extended_kalman_filter import uni_ekf

#: Modules of dev and the last release (1) and of the current package (2): functions and classes
#: with their parameters, `=` behind those that have a default; and scripts among the modules.
LISTING = json.loads(
    (Path(__file__).parent / "golden" / "package_listing.json").read_text(encoding="utf-8")
)
MODULES = [
    (int(generation), name)
    for generation, published in LISTING.items()
    for name in published["modules"]
]
SCRIPTS = [
    (int(generation), name)
    for generation, published in LISTING.items()
    for name in published["scripts"]
]


@pytest.fixture
def installed():
    """Return a function that makes `rps` mean a generation."""
    yield rps_compat.install
    rps_compat.uninstall()


def parameters(function):
    found = []
    for parameter in inspect.signature(function).parameters.values():
        if parameter.name != "self" and parameter.kind is not parameter.VAR_KEYWORD:
            has_default = parameter.default is not parameter.empty
            found.append(parameter.name + ("=" if has_default else ""))
    return found


@pytest.mark.parametrize(("generation", "name"), MODULES)
def test_every_published_module_is_there_with_its_names(installed, generation, name):
    installed(generation=generation)
    module = importlib.import_module(name)
    for public, published in LISTING[str(generation)]["modules"][name].items():
        ours = getattr(module, public)
        both = {public: (ours, published)}
        if isinstance(published, dict):
            both = {method: (getattr(ours, method), p) for method, p in published.items()}
        for function, wanted in both.values():
            assert parameters(function) == [p.replace("=None", "=") for p in wanted], public


def test_optional_noise_of_the_filter_is_none_by_default():
    for kind, methods in ((first_ekf.UnicycleEKF, ["__init__"]), (uni_ekf.UnicycleEKF, ())):
        for method in methods or ["update_brearing", "update_orientation", "update_gyro"]:
            found = inspect.signature(getattr(kind, method)).parameters
            assert [p.default for p in found.values() if p.name.startswith("R_")][-1] is None


@pytest.mark.parametrize(("generation", "name"), SCRIPTS)
def test_an_example_is_no_module_and_says_why(installed, generation, name):
    installed(generation=generation)
    with pytest.raises(ImportError, match="scripts, which run when they are imported"):
        importlib.import_module(name)
    with pytest.raises(ModuleNotFoundError, match=r"No module named 'rps\.utilities\.nothing'"):
        importlib.import_module("rps.utilities.nothing")


# --- The filter --------------------------------------------------------------------------------


def a_filter(state=(0.1, 0.2, 0.3), **noise):
    kind = first_ekf.UnicycleEKF if noise else uni_ekf.UnicycleEKF
    spread, encoders, model = np.diag([0.01, 0.02, 0.03]), np.diag([0.4, 0.5]), np.eye(3) * 1e-3
    return kind(np.array(state), spread, 0.11, 0.016, encoders, model, **noise)


states = st.tuples(st.floats(-1.5, 1.5), st.floats(-1, 1), st.floats(-3, 3))


@given(states, st.floats(-0.2, 0.2), st.floats(-3, 3), st.floats(0.01, 0.1))
def test_prediction_is_the_unicycle_and_its_derivatives(state, v, w, dt):
    ekf, h = a_filter(state), 1e-6
    jumps = np.array(
        [
            (a_filter(np.array(state) + step).form_fx(v, w, dt)[:, 0] + step) / h
            - (a_filter(np.array(state) - step).form_fx(v, w, dt)[:, 0] - step) / h
            for step in h * np.eye(3)
        ]
    )
    np.testing.assert_allclose(ekf.form_F(v, dt), jumps.T / 2, atol=1e-6)
    by_speed = (ekf.form_fx(v + h, w, dt) - ekf.form_fx(v - h, w, dt))[:, 0] / (2 * h)
    np.testing.assert_allclose(ekf.form_G(dt)[:, 0], by_speed, atol=1e-6)
    moved = np.array(state) + ekf.form_fx(v, w, dt)[:, 0]
    ekf.predict(v, w, dt)
    np.testing.assert_allclose(np.cos(ekf.state[2] - moved[2]), 1, atol=1e-12)
    np.testing.assert_allclose(ekf.state[:2], moved[:2])
    assert np.linalg.eigvalsh(ekf.P).min() > 0


@given(states, st.floats(-2, 2), st.floats(-2, 2), st.floats(1e-3, 1))
def test_a_measurement_of_what_is_expected_makes_surer_and_moves_nothing(state, x, y, variance):
    beacon = np.array([x + 3, y])
    way = beacon - np.array(state[:2])
    bearing = np.arctan2(way[1], way[0]) - state[2]
    for update, arguments in (
        ("update_gps", (np.array(state[:2]), variance * np.eye(2))),
        ("update_range", (beacon, np.hypot(*way), variance)),
        ("update_brearing", (beacon, bearing + 2 * np.pi, variance)),
        ("update_orientation", (state[2] - 2 * np.pi, np.array([[variance]]))),
    ):
        ekf = a_filter(state)
        before = ekf.P.copy()
        getattr(ekf, update)(*arguments)
        np.testing.assert_allclose(ekf.state, state, atol=1e-9)
        assert np.linalg.eigvalsh(before - ekf.P).min() > -1e-12
        assert np.trace(ekf.P) < np.trace(before)
        np.testing.assert_array_equal(ekf.covariance, ekf.P)


def test_the_filter_finds_a_robot_that_drives_in_a_circle():
    rng = np.random.default_rng(0)
    pose = np.array([0.5, 0.0, np.pi / 2])
    beacons = np.array([[1.0, 0.5], [-1.0, 0.8]])  # one alone leaves a turn about it open
    ekf = uni_ekf.UnicycleEKF(
        pose + np.array([0.1, -0.1, 0.2]),
        np.eye(3) * 0.02,
        0.11,
        0.016,
        np.eye(2) * 1e-2,
        np.eye(3) * 1e-5,
    )
    for k in range(600):
        v, w, dt = 0.1, 0.2, 0.033
        pose += np.array([v * dt * np.cos(pose[2]), v * dt * np.sin(pose[2]), w * dt])
        ekf.predict(v + rng.normal(0, 1e-3), w + rng.normal(0, 1e-2), dt)
        ekf.update_gyro(w + rng.normal(0, 1e-3), dt, 1e-6)
        beacon = beacons[k % 2]
        way = beacon - pose[:2]
        if k % 5 == 0:
            ekf.update_range(beacon, np.hypot(*way) + rng.normal(0, 0.01), 1e-4)
            bearing = np.arctan2(way[1], way[0]) - pose[2]
            ekf.update_brearing(beacon, bearing + rng.normal(0, 0.02), 4e-4)
    error = ekf.state - pose
    error[2] = np.arctan2(np.sin(error[2]), np.cos(error[2]))
    assert np.hypot(*error[:2]) < 0.02
    assert abs(error[2]) < 0.05
    # And it knows how sure it is: within four standard deviations.
    assert error @ np.linalg.solve(ekf.P, error) < 16


def test_the_gyro_tells_how_far_the_robot_turned_and_not_where_to():
    ekf = a_filter()
    for _ in range(50):
        ekf.predict(0.0, 1.8, 0.1)  # the encoders say 1.8 rad/s
        ekf.update_gyro(2.0, 0.1, 1e-9)
    turned = ekf.state[2] - 0.3
    assert np.arctan2(np.sin(turned - 10), np.cos(turned - 10)) == pytest.approx(0, abs=0.01)
    assert ekf.P[2, 2] == pytest.approx(0.03, rel=0.01), "the first heading is as unsure as ever"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: a_filter().update_brearing([1, 1], 0.1), "R_bearing is None, expected a positive"),
        (
            lambda: a_filter().update_range([1, 1], 0.1, -1.0),
            "R_range is -1.0, expected a positive",
        ),
        (lambda: a_filter().update_gps([1, 1, 1], np.eye(2)), r"gps_measurement has shape \(3,\)"),
        (lambda: a_filter(R_gps=None).update_gps([1, 1]), "R_gps is None, expected a positive def"),
        (lambda: a_filter(R_gps=None).update_imu([1, 1, 1]), "was never published"),
        (lambda: a_filter((0, np.nan, 0)), "initial_state"),
        (
            lambda: uni_ekf.UnicycleEKF(np.zeros(3), np.eye(3), -1, 1, np.eye(2), np.eye(3)),
            "b is -1",
        ),
    ],
)
def test_the_filter_refuses_in_words(call, message):
    with pytest.raises((ValueError, NotImplementedError), match=message):
        call()


# --- The sensors of the last release of generation 1 -------------------------------------------


@pytest.fixture
def robots(installed):
    """Return a function that makes two robots of generation 1."""
    installed(generation=1)
    from rps.robotarium import Robotarium

    def make(**options):
        start = np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, np.pi]])
        return Robotarium(2, False, False, start, **options)

    return make


def drive(robotarium, steps, v=0.1, w=0.5):
    for _ in range(steps):
        robotarium.get_poses()
        robotarium.set_velocities([0, 1], np.array([[v, v], [w, w]]))
        robotarium.step()


def test_sensors_of_generation_1_read_what_those_of_generation_2_do(robots):
    wall = np.array([[[0.0, 0.0], [-1.0, 1.0]]])  # x of both ends, then y
    r = robots(use_distance_sensors=True, obstacles=wall)
    r.distance_sensor_error = r.distance_sensor_dropout_prob = r.distance_sensor_outlier_prob = 0.0
    assert (r.get_distances() == -1).all()
    drive(r, 1, 0.0, 0.0)
    np.testing.assert_allclose(r.get_distances()[3], [0.45, 0.45])
    points = r.transform_distance_readings()
    assert points.shape == (2, 14)
    np.testing.assert_allclose(points[0, [3, 10]], 0, atol=1e-12)
    from rps.utilities.misc import calculate_global_distance_points, rotation_matrix

    ends = calculate_global_distance_points(r, r.poses, r.get_distances())
    np.testing.assert_array_equal(ends[:, :, 1], points[:, 7:])
    assert rotation_matrix(np.array([0.1, 0.2])).shape == (2, 3, 3)
    drive(r, 100)
    assert r.get_accelerations().mean(axis=1)[2] == pytest.approx(-9.81, abs=0.2)
    assert r.get_gyros()[2] == pytest.approx([0.5, 0.5], abs=0.02)
    assert r.get_magnetic_fields().shape == (3, 2)
    assert np.abs(r.get_orientations() - np.rad2deg(r.poses[2]) % 360).max() < 3


def test_where_sensors_are_read_commands_are_cut_as_in_the_release_that_has_them(robots):
    r = robots(use_distance_sensors=True)
    hard = np.array([[-0.05, 0.3], [2 * np.pi, -1.0]])
    r.get_poses()
    r.set_velocities([0, 1], hard)
    np.testing.assert_allclose(r.velocities, [[-0.05, 0.2], [r.max_angular_velocity, -1.0]])
    assert hard[0, 1] == 0.3
    r.step()
    assert r.poses[0, 0] < -0.5  # uncut, both wheels would be at their limit, and it would stand
    r.get_poses()
    r.set_velocities(np.array([1]), np.array([[0.1], [0.0]]))
    np.testing.assert_allclose(r.velocities[:, 1], [0.1, 0.0])
    with pytest.raises(CommandError, match=r"shape \(2, 3\) for the robots"):
        r.set_velocities([0, 1], np.zeros((2, 3)))
    plain = robots()
    plain.set_velocities([0, 1], hard)
    assert plain.velocities is hard


def test_encoders_count_from_the_start_whenever_they_are_asked_first(robots):
    np.random.seed(2)  # noqa: NPY002 - what an instance's noise is drawn from
    early, late = robots(), robots()
    early.get_encoders()
    drive(early, 90)
    drive(late, 90)
    assert early.get_encoders().dtype == np.int32
    assert np.abs(early.get_encoders() - late.get_encoders()).max() <= 40  # of some 8000
    assert late.get_encoders()[1].min() > 5000


def test_who_asks_for_no_sensor_keeps_his_random_numbers(robots):
    np.random.seed(3)  # noqa: NPY002
    drive(robots(), 5)
    first = np.random.rand()  # noqa: NPY002
    np.random.seed(3)  # noqa: NPY002
    assert np.random.rand() == first  # noqa: NPY002


def test_leds_are_kept_and_refused_in_words(robots):
    r = robots()
    r.set_leds([1], [[255], [0], [9]])
    np.testing.assert_array_equal(r.leds[:, 1], [255, 0, 9])
    with pytest.raises(CommandError, match=r"leds have shape \(2, 1\), expected \(3, 1\)"):
        r.set_leds([0], [[1], [2]])
    with pytest.raises(CommandError, match="there are robots 0 to 1"):
        r.set_leds([2], [[1], [2], [3]])
