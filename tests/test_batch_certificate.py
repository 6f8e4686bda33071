"""A batch certificate answers what a single one answers for each team."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from batch_teams_alone import ARENA, LIMITS, NINE, assert_as_alone, states

from barrier_certificates.batch import BatchCertificate, compiling, numba_is_installed
from barrier_certificates.certificate_errors import (
    EngineNotInstalledError,
    InfeasibleError,
    ParameterError,
    ShapeError,
)
from barrier_certificates.deadlock import DeadlockParameters
from barrier_certificates.late.late_certificate import LateCertificate
from barrier_certificates.late.late_robots import LateRobots
from barrier_certificates.rows import Disc, Segment
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate

ROOT = Path(__file__).resolve().parent.parent
ENGINES = (pytest.param("numba", marks=pytest.mark.slow), "numpy")
compiled_only = pytest.mark.skipif(not numba_is_installed(), reason="needs numba")


@compiled_only
def test_kernels_in_plain_python_answer_as_alone() -> None:
    """What is compiled, without the half minute that compiling takes."""
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    words = [sys.executable, str(ROOT / "tests/batch_teams_alone.py")]
    told = subprocess.run(words, env=environment, capture_output=True, text=True, cwd=ROOT)
    assert told.stdout == "as alone\n", told.stderr


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("kind", ["spread", "packed", "tight", "corner", "random"])
def test_every_team_gets_the_answer_that_it_gets_alone(kind: str, engine: str) -> None:
    teams = 20 if engine == "numba" else 2
    assert_as_alone(NINE, *states(kind, teams), engine, steps=3)


@pytest.mark.slow
@compiled_only
def test_obstacles_disturbances_and_polygons_count_as_alone() -> None:
    corners = np.array([[-1.2, 1.2, 0.0], [-0.9, -0.9, 1.3]])
    certificate = UnicycleCertificate(
        0.2, 500.0, boundary=corners, unsafe_gain=50.0, wheel_disturbance=0.5, **LIMITS,
        obstacles=(Disc((0.0, 0.0), 0.1, (0.02, 0.0)), Segment((0.3, -0.5), (0.6, -0.2), 0.02)),
    )  # fmt: skip
    for kind in ("spread", "packed"):
        assert_as_alone(certificate, *states(kind, 8), "numba", steps=2)


@pytest.mark.slow
@compiled_only
def test_late_robots_are_answered_as_alone_with_what_was_sent_remembered() -> None:
    late = LateRobots(dead_time=(0.19, 0.2), lag=(0.17, 0.18), position_error=0.001)
    certificate = LateCertificate(
        0.16, 100.0, wall_gain=20.0, boundary=ARENA, robots=late, **LIMITS
    )
    for kind in ("spread", "corner"):
        assert_as_alone(certificate, *states(kind, 4), "numba", steps=4)


@pytest.mark.slow
@compiled_only
def test_teams_of_points_and_projected_velocities_are_those_alone() -> None:
    desired, poses = states("packed", 8)
    points = SingleIntegratorCertificate(0.2, boundary=ARENA)
    velocity, _ = BatchCertificate(points, engine="numba")(desired, poses[:, :2])
    projected, _ = BatchCertificate(NINE, engine="numba").project(desired, poses)
    for team in range(8):
        expected = SingleIntegratorCertificate(0.2, boundary=ARENA)(desired[team], poses[team, :2])
        np.testing.assert_allclose(velocity[team], expected[0], rtol=0, atol=1e-8)
        np.testing.assert_allclose(
            projected[team], NINE.project(desired[team], poses[team])[0], rtol=0, atol=1e-8
        )


@compiled_only
def test_without_a_guess_the_climb_finds_the_same_point(monkeypatch: pytest.MonkeyPatch) -> None:
    from barrier_certificates.batch import active_rows, layout, search, write_rows

    plain = (
        "write_excess",
        "append",
        "copy",
        "products",
        "broken_by",
        "project_on",
        "solve",
        "subtract",
    )
    for module in (search, active_rows, write_rows):
        for name in (*plain, "guess", "climb", "_most_broken", "_proves", "_take_up"):
            kernel = getattr(module, name, None)
            if hasattr(kernel, "py_func"):
                monkeypatch.setattr(module, name, kernel.py_func)
    desired, poses = states("corner", 3)
    for team in range(3):
        velocity, info = NINE.project(desired[team], poses[team])
        recipe = layout.recipe_of(*NINE.row_families(), cautious=False)
        pattern = layout.rows_of(recipe, 9)
        single = info.rows
        assert single is not None
        rows = pattern._replace(
            ax=single.coefficient[0], ay=single.coefficient[1], bound=single.bound
        )
        space = active_rows.space_for.py_func(9, len(single))
        space.target[:] = desired[team]
        worst = search.write_excess(rows, space.target, space.least, space.gap)
        assert search.climb(rows, space, worst) == len(info.binding)
        np.testing.assert_allclose(space.point, velocity, rtol=0, atol=1e-8)


def test_what_nobody_can_answer_follows_the_policy() -> None:
    desired, poses = states("packed", 3)
    poses[1, :, 0] = poses[1, :, 1]  # two robots in one place
    poses[2, 0, 3] = np.nan
    _, info = BatchCertificate(NINE, engine="numpy")(desired, poses)
    assert [str(status) for status in info.statuses()][1:] == ["relaxed", "failed"]
    raising = BatchCertificate(replace(NINE, on_infeasible="raise"), engine="numpy")
    with pytest.raises(InfeasibleError, match="no velocity satisfies"):
        raising(desired[:2], poses[:2])


def test_what_cannot_be_done_is_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ParameterError, match="engine is 'jax'"):
        BatchCertificate(NINE, engine="jax")  # type: ignore[arg-type]
    with pytest.raises(ShapeError, match=r"\(2, 9\) and states \(3, 9\)"):
        BatchCertificate(NINE)(np.zeros((2, 9)), np.zeros((3, 9)))
    monkeypatch.setattr(compiling, "numba_is_installed", lambda: False)
    with pytest.raises(EngineNotInstalledError, match=r"posflock-robotarium\[fast\]"):
        BatchCertificate(NINE, engine="numba")
    assert not BatchCertificate(NINE).compiled


@compiled_only
def test_who_watches_for_deadlocks_is_never_compiled() -> None:
    watching = UnicycleCertificate(0.2, deadlock=DeadlockParameters())
    assert not BatchCertificate(watching).compiled
    with pytest.raises(ParameterError, match="without deadlock"):
        BatchCertificate(watching, engine="numba")
