"""What both generations' Robotarium classes do beyond the recorded answers."""

import gc
import subprocess
import sys
import textwrap

import numpy as np
import pytest

import rps_compat
from rps_compat.errors import InitialConditionsError, UnreachableError, WrongGenerationError
from rps_compat.session import Session

APART = np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, np.pi]])


@pytest.fixture(params=[1, 2])
def generation(request):
    rps_compat.install(generation=request.param)
    yield request.param
    rps_compat.uninstall()


def make(generation, poses=APART, **kwargs):
    from rps.robotarium import Robotarium

    if generation == 2:
        kwargs.setdefault("skip_initialization", True)
    kwargs.setdefault("show_figure", False)
    kwargs.setdefault("sim_in_real_time", False)
    kwargs.setdefault("number_of_robots", poses.shape[1])
    return Robotarium(initial_conditions=poses, **kwargs)


def drive(r, velocities, steps):
    for _ in range(steps):
        r.get_poses()
        r.set_velocities(np.arange(r.number_of_robots), velocities)
        r.step()


def test_poses_are_live_in_generation_1_and_copies_in_2(generation):
    r = make(generation)
    x = r.get_poses()
    r.set_velocities(np.arange(2), np.array([[0.1, 0.1], [0, 0]]))
    r.step()
    assert (x[0, 0] != -0.5) == (generation == 1)


def test_callers_array_is_not_damaged_and_integers_work(generation):
    poses = np.array([[-1, 1], [0, 0], [0, 1]])
    drive(make(generation, poses), np.array([[0.1, 0.1], [0.1, 0.1]]), 10)
    assert (poses == [[-1, 1], [0, 0], [0, 1]]).all()
    assert poses.dtype.kind == "i"


def test_counters_belong_to_one_instance(generation):
    first = make(generation)
    drive(first, np.array([[5.0, 0], [0, 0]]), 3)
    assert first._errors
    second = make(generation)
    drive(second, np.zeros((2, 2)), 3)
    assert second._errors == {}


@pytest.mark.parametrize("robots", [1, 22, 23, 50])
def test_up_to_fifty_robots(generation, robots):
    r = make(generation, _grid(robots))
    drive(r, np.zeros((2, robots)), 2)
    assert r.get_poses().shape == (3, robots)


@pytest.mark.parametrize("robots", [5, 18, 25, 50])
def test_large_teams_need_no_initial_conditions(generation, robots):
    from rps.robotarium import Robotarium

    options = {"skip_initialization": True} if generation == 2 else {}
    for seed in range(8):
        starts = []
        for _ in range(2):
            np.random.seed(seed)  # noqa: NPY002 - what scripts do
            r = Robotarium(
                number_of_robots=robots, show_figure=False, sim_in_real_time=False, **options
            )
            starts.append(np.array(r.get_poses()))
        assert np.array_equal(*starts)
        i, j = np.triu_indices(robots, 1)
        apart = np.hypot(*(starts[0][:2, i] - starts[0][:2, j])).min()
        published = {1: 0.2, 2: 0.5}[generation]
        assert apart >= (published if robots == 5 else min(published, 0.26))


@pytest.mark.parametrize("robots", [20, 50])
def test_large_teams_are_driven_to_drawn_poses(robots):
    from rps_compat.v2.robotarium import Robotarium

    np.random.seed(1)  # noqa: NPY002 - what scripts do
    r = Robotarium(number_of_robots=robots, show_figure=False, sim_in_real_time=False)
    assert np.hypot(*(r.get_poses() - r._targets)[:2]).max() <= 0.02
    assert r._errors == {}


def _grid(robots):
    x, y = np.meshgrid(np.linspace(-1.4, 1.4, 10), np.linspace(-0.8, 0.8, 5))
    return np.stack([x.ravel(), y.ravel(), np.zeros(50)])[:, :robots]


@pytest.mark.parametrize(
    ("poses", "message"),
    [
        ([[0, np.nan], [0, 0], [0, 0]], r"initial_conditions\[0, 1\] \(x of robot 1\) is nan"),
    ],
)
def test_impossible_initial_conditions_name_the_robot(generation, poses, message):
    with pytest.raises(InitialConditionsError, match=message):
        make(generation, np.array(poses))


@pytest.mark.parametrize("driven", [False, True])
def test_starting_outside_is_warned_of_and_counted(generation, driven):
    poses = np.array([[0, 1.7], [0, 0], [0, 0.0]])
    session = Session(initial="drive" if driven else "exact")
    warned = pytest.warns(UserWarning, match=r"outside the arena .* robot 1 at \(1.7, 0\)")
    with session.active(), warned:
        r = make(generation, poses)
    drive(r, np.zeros((2, 2)), 3)
    assert np.abs(r.get_poses()[:2] - poses[:2]).max() < 0.02
    assert r._arena.violations.outside_steps >= 2
    assert r._errors


def test_starting_too_close_is_warned_of_and_counted(generation):
    with pytest.warns(UserWarning, match="robots 0 and 1 would start too close"):
        r = make(generation, np.array([[0, 0.05], [0, 0], [0, 0.0]]))
    drive(r, np.zeros((2, 2)), 1)
    assert r._errors


def test_names_of_the_other_generation_are_answered_with_the_right_one(generation):
    r = make(generation)
    wrong, right = {
        1: ("debug", "call_at_scripts_end()"),
        2: ("time_step", "TIME_STEP"),
    }[generation]
    with pytest.raises(
        WrongGenerationError, match=f"generation {generation} calls this {right[:9]}"
    ):
        getattr(r, wrong)
    assert not hasattr(r, wrong)
    with pytest.raises(AttributeError, match=r"no attribute 'fly'$"):
        _ = r.fly


def test_constants_that_a_script_changes_are_obeyed(generation):
    r = make(generation)
    name = "time_step" if generation == 1 else "TIME_STEP"
    setattr(r, name, 0.1)
    drive(r, np.array([[0.1, 0.1], [0, 0]]), 1)
    assert r.get_poses()[0, 0] == pytest.approx(-0.49)


def test_a_misspelt_argument_is_warned_of():
    rps_compat.install(generation=2)
    with pytest.warns(UserWarning, match="'skip_initialisation'; did you mean skip_init"):
        make(2, skip_initialisation=True)
    rps_compat.uninstall()


def test_no_figure_and_no_matplotlib_until_asked_for(generation):
    program = f"""
        import sys, numpy as np, rps_compat
        rps_compat.install(generation={generation})
        from rps.robotarium import *
        options = dict(skip_initialization=True) if {generation} == 2 else dict()
        r = Robotarium(number_of_robots=1, show_figure=False, sim_in_real_time=False,
                       initial_conditions=np.zeros((3, 1)), **options)
        r.get_poses(); r.step(); r.get_poses()
        assert "matplotlib" not in sys.modules, "a hidden instance needs no matplotlib"
        axes = r.axes if {generation} == 1 else r._axes_handle
        import matplotlib.pyplot as plt
        assert plt.gca() is axes
    """
    subprocess.run([sys.executable, "-c", textwrap.dedent(program)], check=True)


def test_figures_do_not_grow_in_number(generation):
    import matplotlib.pyplot as plt

    for _ in range(5):
        r = make(generation, show_figure=True)
        axes = plt.gca()
    assert axes is (r.axes if generation == 1 else r._axes_handle)
    del r
    gc.collect()
    make(generation, show_figure=True)
    assert len(plt.get_fignums()) == 1


@pytest.mark.slow
def test_a_thousand_instances_need_no_more_memory_than_a_hundred(generation):
    import resource

    def peak_after(instances):
        for _ in range(instances):
            drive(make(generation, show_figure=True), np.zeros((2, 2)), 5)
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    first = peak_after(100)
    assert peak_after(1000) - first < 10_000, "kB"


def test_patches_are_where_the_robots_are_when_drawn(generation):
    r = make(generation, show_figure=True)
    figure = r.figure if generation == 1 else r._fig
    figure.canvas.draw()
    drive(r, np.array([[0.2, 0.2], [0, 0]]), 100)
    figure.canvas.draw()
    if generation == 1:
        middle = r.chassis_patches[0].get_center()[0]
    else:
        middle = r._robot_handle[0].patches[2].get_path().vertices[:, 0].mean()
    assert middle == pytest.approx(-0.5 + 0.66, abs=0.02)


@pytest.mark.parametrize("robots", [1, 2, 9, 20, 50])
def test_every_team_that_fits_is_driven_to_its_poses(robots):
    rps_compat.install(generation=2)
    rng = np.random.default_rng(robots)
    poses = _grid(50)[:, rng.permutation(50)[:robots]]
    poses[2] = rng.uniform(-np.pi, np.pi, robots)
    with Session(seed=3).active():
        r = make(2, poses, skip_initialization=False)
    rps_compat.uninstall()
    reached = r.get_poses()
    assert np.hypot(*(reached - poses)[:2]).max() <= 0.02
    turn = (reached - poses)[2]
    assert np.abs(np.arctan2(np.sin(turn), np.cos(turn))).max() <= 0.18
    assert r._errors == {}
    assert r._iteration > 1


def test_a_ring_changes_places():
    """A drive from where the robots are, which nobody could assign: all meet in the middle."""
    rps_compat.install(generation=2)
    angles = np.linspace(0, 2 * np.pi, 6, endpoint=False)
    ring = np.stack([0.6 * np.cos(angles), 0.6 * np.sin(angles), angles])
    across = np.stack([-ring[0], -ring[1], angles])
    with Session(seed=0).active():
        r = make(2, ring)
        r.initialize(across)
    rps_compat.uninstall()
    assert np.hypot(*(r.get_poses() - across)[:2]).max() <= 0.02
    assert r._errors == {}


def test_poses_where_no_team_fits_are_refused():
    rps_compat.install(generation=2)
    with pytest.raises(InitialConditionsError, match=r"robots 0 and 1 .* 10.0 cm apart"):
        make(2, np.array([[0, 0.1], [0, 0], [0, 0.0]]), skip_initialization=False)
    rps_compat.uninstall()


def test_a_drive_in_which_nobody_comes_nearer_is_given_up(monkeypatch):
    monkeypatch.setattr(
        "rps_compat.arena.Arena._drive", lambda *_: None
    )  # their batteries are flat
    rps_compat.install(generation=2)
    with pytest.raises(UnreachableError, match=r"after 60(\.\d)? s of driving, 2 of 2"):
        make(2, skip_initialization=False)
    rps_compat.uninstall()


def test_a_drive_that_fails_says_who_is_late(monkeypatch):
    monkeypatch.setattr("rps_compat.initial_drive.LONGEST_DRIVE", 0.33)
    rps_compat.install(generation=2)
    with pytest.raises(UnreachableError, match=r"0.33 s of driving, \d of 2 robots .* cm away"):
        make(2, skip_initialization=False)
    rps_compat.uninstall()
