"""Teams in a batch do what each would do alone."""

from dataclasses import replace

import numpy as np
import pytest

from barrier_certificates.batch import numba_is_installed
from posflock_robotarium.alignment.summary import summarise
from posflock_robotarium.batch.batch_flock import BatchFlock
from posflock_robotarium.batch.batch_trial import simulate_teams
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.flock import EXPERIMENT_CERTIFICATE, Flock
from posflock_robotarium.flocking.law import PAPER_EXPERIMENT, LawParameters
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.simulation.flock_trial import simulate
from posflock_robotarium.sweep.execution import batches, compute
from posflock_robotarium.sweep.study import parse_study
from rps_compat.late_profiles import late_certificate
from rps_compat.profiles import load_profile

ENGINES = ("numba", "numpy") if numba_is_installed() else ("numpy",)
COMPILED_OR_NOT = [
    pytest.param(engine, marks=[pytest.mark.slow] if engine == "numba" else [])
    for engine in ENGINES
]
SEEDS = (3, 1, 4, 159, 2)
TIMED = replace(EXPERIMENT_CERTIFICATE, safety_radius=0.185, time_step=0.033)
#: Metres that teams are put aside of the centre: at two walls they are steered, in a corner cut.
ASIDE = np.array([(0.0, 0.0), (0.95, 0.0), (0.0, -0.4), (-0.95, 0.4), (0.0, 0.0)])


def starts() -> np.ndarray:
    """Return starts of five teams of nine robots."""
    teams = [random_poses(9, np.random.default_rng(seed), side=0.9, spacing=0.22) for seed in SEEDS]
    poses = np.stack(teams)
    poses[:, :2] += ASIDE[:, :, None]
    return poses


def assert_as_alone(flock: Flock, duration: float, profile: str, *engines: str) -> None:
    realism = load_profile(profile)
    alone = [
        simulate(flock, start, duration, realism=realism.start(), seed=seed)
        for start, seed in zip(starts(), SEEDS, strict=True)
    ]
    for engine in engines:
        many = simulate_teams(
            flock, starts(), duration, seeds=SEEDS, realism=realism, engine=engine, threads=1
        )
        for found, expected in zip(many, alone, strict=True):
            np.testing.assert_allclose(
                found.true_poses, expected.true_poses, rtol=0, atol=1e-9, err_msg=engine
            )
            for name in ("t", "poses", "commands", "intervention", "clearance"):
                wanted = getattr(expected.log, name)
                np.testing.assert_allclose(getattr(found.log, name), wanted, rtol=0, atol=1e-9)
            assert found.log.status.tolist() == expected.log.status.tolist()
            assert found.log.parameters == expected.log.parameters


@pytest.mark.slow  # compiles, where nobody has before
@pytest.mark.parametrize("profile", ["ideal", "gritsbot_x"])
def test_trials_of_a_batch_are_those_of_its_teams(profile: str) -> None:
    assert_as_alone(Flock(), 6.6, profile, *ENGINES)


@pytest.mark.slow
@pytest.mark.parametrize("profile", ["ideal", "gritsbot_x", "gternal"])
def test_long_trials_too(profile: str) -> None:
    assert_as_alone(Flock(), 20.0, profile, *ENGINES)


@pytest.mark.parametrize(
    "flock",
    [
        Flock(walls="certificate", model=Model.VELOCITY, neighbour_hysteresis=0.0),
        Flock(certificate=replace(EXPERIMENT_CERTIFICATE, pair_rows=False)),
        Flock(certificate=late_certificate(TIMED, load_profile("gritsbot_x"), barrier_gain=2e4)),
    ],
    ids=["papers law", "nobody kept apart", "late robots"],
)
def test_other_flocks_too(flock: Flock) -> None:
    assert_as_alone(flock, 0.8, "gritsbot_x", "numpy")


def own_laws() -> list[LawParameters]:
    """Return a law for each of five teams, no two alike in any number; one with a robot's each."""
    usual = replace(PAPER_EXPERIMENT, persistence=3.0).as_dict()  # counts from 1/3 s on
    drawn = np.random.default_rng(8).uniform(0.8, 1.2, (5, len(usual)))
    laws = [LawParameters(*(row * list(usual.values()))) for row in drawn]
    laws[2] = replace(laws[2], radius=np.linspace(0.6, 0.9, 9), speed_limit=np.full(9, 0.14))
    return laws


@pytest.mark.parametrize("engine", COMPILED_OR_NOT)
@pytest.mark.parametrize("model", list(Model))
def test_each_team_may_follow_a_law_of_its_own(model: Model, engine: str) -> None:
    laws = own_laws()
    names = ("gritsbot_x", "ideal", "gritsbot_x", "harsh", "gternal")
    realism = [load_profile(name) for name in names]
    flock = Flock(model=model)
    many = simulate_teams(
        flock, starts(), 1.0, seeds=SEEDS, realism=realism, laws=laws, engine=engine
    )
    for team, found in enumerate(many):
        own, real = Flock(laws[team], model=model), realism[team].start()
        alone = simulate(own, starts()[team], 1.0, realism=real, seed=SEEDS[team])
        np.testing.assert_allclose(found.true_poses, alone.true_poses, rtol=0, atol=1e-12)
        np.testing.assert_allclose(found.log.commands, alone.log.commands, rtol=0, atol=1e-12)
        assert found.log.parameters == alone.log.parameters


def test_laws_that_no_batch_can_follow_are_refused() -> None:
    laws = own_laws()
    with pytest.raises(ParameterError, match="laws: expected 5, one for each team, got 4"):
        BatchFlock(Flock(), 5, laws=laws[:4])
    with pytest.raises(ParameterError, match=r"less than the radius, 0\.1 m; got 0\.15"):
        BatchFlock(Flock(), 5, laws=[*laws[:4], replace(laws[4], radius=0.1)])
    with pytest.raises(ParameterError, match="teams of one size, got radius for 4 and for 9"):
        BatchFlock(Flock(), 5, laws=[*laws[:4], replace(laws[4], radius=np.full(4, 0.7))])
    eight = starts()[:, :, :8]
    for flock, poses in (
        (BatchFlock(Flock(), 5, laws=laws, engine="numpy"), eight),
        (Flock(laws[2]), eight[2]),
    ):
        with pytest.raises(ParameterError, match="one value for each of 8 agents, got 9"):
            flock.step(poses)


@pytest.mark.slow  # compiles, where nobody has before
def test_a_team_is_the_same_in_any_company() -> None:
    together = simulate_teams(Flock(), starts(), 3.5, seeds=SEEDS)
    for team in (1, 3):
        (alone,) = simulate_teams(Flock(), starts()[[team]], 3.5, seeds=[SEEDS[team]])
        np.testing.assert_allclose(together[team].true_poses, alone.true_poses, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "duration",
    [1.5, pytest.param(10.0, marks=pytest.mark.slow)],
    ids=["numpy", "compiled"],
)
def test_rows_of_a_study_are_those_of_single_trials(duration: float) -> None:
    given = {"duration": duration, "profile": "gritsbot_x"}
    study = parse_study({"experiment": "robots", "replications": 2, "parameters": given})
    profile = load_profile("gritsbot_x")
    (runs,) = batches(study.runs(), study.experiment)
    rows = compute("robots", runs)
    for run, row in zip(study.runs(), rows, strict=True):
        start = random_poses(9, np.random.default_rng(run.stream), side=1.0, spacing=0.3)
        seed = int(run.stream.spawn(1)[0].generate_state(1, np.uint64)[0])
        trial = simulate(Flock(), start, duration, realism=profile.start(), seed=seed)
        expected = summarise(trial.truth()).as_dict()
        for name in set(expected) - {"duration", "ended"}:
            wanted = np.nan if expected[name] is None else expected[name]
            np.testing.assert_allclose(row[name], wanted, rtol=0, atol=1e-9, err_msg=name)
    (again,) = compute("robots", runs[1:])  # as where a batch fails, and is done run by run
    assert again["mean_speed"] == pytest.approx(rows[1]["mean_speed"], abs=1e-12)


def test_teams_that_start_too_close_are_told_of_once() -> None:
    poses = starts()
    poses[2, :2] *= 0.5
    flocks = BatchFlock(Flock(), 5, engine="numpy")
    with pytest.warns(UserWarning, match="1 of 5 teams, the first of them 2, start closer"):
        first = flocks.step(poses).command
    flocks.step(poses)
    flocks.reset()
    with pytest.warns(UserWarning, match="1 of 5 teams"):
        np.testing.assert_array_equal(flocks.step(poses).command, first)


def test_what_cannot_be_stepped_is_refused() -> None:
    flocks = BatchFlock(Flock(), 5, engine="numpy")
    with pytest.raises(ParameterError, match=r"expected shape \(5, 3, N\).*got \(4, 3, 9\)"):
        flocks.step(starts()[:4])
    lost = starts()
    lost[3, 1, 7] = np.nan
    with pytest.raises(ParameterError, match="got y = nan of robot 7 in team 3"):
        flocks.step(lost)
    with pytest.raises(ParameterError, match="got 0"):
        BatchFlock(Flock(), 0)
    with pytest.raises(ParameterError, match="a seed for each of B teams"):
        simulate_teams(Flock(), starts(), 1.0, seeds=[1])
