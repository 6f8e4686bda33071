"""A batch arena does what as many single arenas do."""

from dataclasses import replace

import numpy as np
import pytest

from barrier_certificates.batch import BatchCertificate, numba_is_installed
from barrier_certificates.unicycle import UnicycleCertificate
from rps_compat.arena import Arena
from rps_compat.arena_guests import Realism
from rps_compat.batch import BatchArena, Hold, Rollout, ToGoals, rollout
from rps_compat.batch.team_profiles import kinds_of
from rps_compat.distributions import DistributionKind, RobotDistribution, constant
from rps_compat.errors import CommandError, InitialConditionsError
from rps_compat.profiles import NAMES, load_profile
from rps_compat.realism import Imperfections, Lag, Profile

#: What compiles takes ten seconds, where nobody has before.
ENGINES = (
    pytest.param(
        "numba",
        marks=[
            pytest.mark.slow,
            pytest.mark.skipif(not numba_is_installed(), reason="needs numba"),
        ],
    ),
    "numpy",
)
COUNTERS = (
    "saturated_steps", "actuator_steps", "outside_steps", "outside_by_robot", "close_pairs",
    "close_by_robot", "close_steps",
)  # fmt: skip
TEAMS, ROBOTS, STEPS = 4, 5, 90


def starts() -> np.ndarray:
    """Return poses of which some are outside, some too close, some beyond half a turn."""
    rng = np.random.default_rng(3)
    poses = rng.uniform(-1.0, 1.0, (TEAMS, 3, ROBOTS)) * np.array([1.65, 1.05, 4.0])[:, None]
    poses[1, :2] *= 0.1
    return poses


def harsher(lag: RobotDistribution, gain: float) -> Profile:
    """Return a profile that differs from others in what robots draw only."""
    harsh = load_profile("harsh")
    assert harsh.gains is not None
    return replace(
        harsh, name=f"±{gain}", lag=Lag(lag), gains=replace(harsh.gains, speed=constant(gain))
    )


#: One of every kind; three that differ in distributions, which are one large team, and the ideal.
KINDS = [load_profile(name) for name in ("gternal", "ideal", "gritsbot_x", "gternal")]
DRAWN = [
    harsher(constant(0.1), 0.9),
    None,
    harsher(RobotDistribution(DistributionKind.UNIFORM, (0.0, 0.3)), 1.0),
    harsher(RobotDistribution(DistributionKind.ROBOTS, (0.1, 0.2, 0.0, 0.3, 0.2)), 1.1),
]
PROFILES = {name: [load_profile(name)] * TEAMS for name in NAMES}
PROFILES |= {"of every kind": KINDS, "drawn otherwise": DRAWN}


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", PROFILES)
def test_teams_move_and_fail_as_they_would_alone(name: str, engine: str) -> None:
    profiles, rng = PROFILES[name], np.random.default_rng(5)
    realism = profiles[0] if name in NAMES else profiles
    batch = BatchArena(starts(), realism=realism, seeds=range(TEAMS), engine=engine)
    alone = [
        Arena(poses, realism=one and one.start(), rng=np.random.default_rng(team))
        for team, (poses, one) in enumerate(zip(starts(), profiles, strict=True))
    ]
    for step in range(STEPS):
        if step % 40 < 15:  # then silence, until robots brake
            batch.commands = rng.uniform(-1.0, 1.0, (TEAMS, 2, ROBOTS)) * [[0.22], [4.0]]
            for team, arena in enumerate(alone):
                arena.commands = batch.commands[team].copy()
        if step % 3:  # who is not looked at draws nothing
            seen = batch.observe()
            for team, arena in enumerate(alone):
                np.testing.assert_allclose(seen[team], arena.observe(), rtol=0, atol=1e-12)
        batch.step()
        for team, arena in enumerate(alone):
            arena.step()
            np.testing.assert_allclose(batch.poses[team], arena.poses, rtol=0, atol=1e-12)
            np.testing.assert_allclose(batch.velocities[team], arena.velocities, atol=1e-12)
    for team, arena in enumerate(alone):
        counted = batch.violations.team(team)
        for counter in COUNTERS:
            assert getattr(counted, counter) == getattr(arena.violations, counter)
        fastest = arena.violations.largest_wheel_velocity
        assert counted.largest_wheel_velocity == pytest.approx(fastest)
    assert not batch.violations.clean[1]


def test_teams_that_differ_in_what_robots_draw_are_one_large_team() -> None:
    assert [teams for _, teams in kinds_of(DRAWN)] == [[0, 2, 3], [1]]
    assert [teams for _, teams in kinds_of(KINDS)] == [[0, 3], [1], [2]]
    assert kinds_of([None, load_profile("ideal")]) == [(None, [0, 1])]


class Fading(Realism):
    """Motors that weaken with time, and tracking that is off: no more than the protocol asks."""

    def reset(self, poses, time_step, rng):
        self.rng = rng

    def actuate(self, velocities, poses, time):
        return velocities / (1.0 + time)

    def observe(self, poses):
        return poses + self.rng.normal(0.0, 0.01, poses.shape)


@pytest.mark.parametrize("engine", ENGINES)
def test_every_team_may_have_imperfections_of_its_own(engine: str) -> None:
    def given(harsh: Profile | Realism) -> list[Profile | Realism | None]:
        return [Fading(), None, harsh, Fading()]

    BatchArena(starts(), realism=[Fading() for _ in starts()], seeds=range(TEAMS), engine=engine)
    harsh = load_profile("gternal")

    batch = BatchArena(starts(), realism=given(harsh), seeds=range(TEAMS), engine=engine)
    alone = [
        Arena(poses, realism=realism, rng=np.random.default_rng(team))
        for team, (poses, realism) in enumerate(
            zip(starts(), given(Imperfections(harsh)), strict=True)
        )
    ]
    batch.commands = np.random.default_rng(5).uniform(-0.1, 0.1, (TEAMS, 2, ROBOTS))
    for team, arena in enumerate(alone):
        arena.commands = batch.commands[team].copy()
    for _ in range(30):  # a command, then silence
        seen = batch.observe()
        batch.step()
        for team, arena in enumerate(alone):
            np.testing.assert_allclose(seen[team], arena.observe(), rtol=0, atol=1e-12)
            arena.step()
            np.testing.assert_allclose(batch.velocities[team], arena.velocities, atol=1e-12)
    for team, arena in enumerate(alone):
        np.testing.assert_allclose(batch.poses[team], arena.poses, rtol=0, atol=1e-12)


@pytest.mark.slow
@pytest.mark.skipif(not numba_is_installed(), reason="needs numba")
def test_a_compiled_rollout_is_the_steps_one_by_one() -> None:
    certificate = UnicycleCertificate(
        0.2, 2000.0, boundary=(-1.6, 1.6, -1.0, 1.0), speed_limit=0.15, time_step=0.033
    )
    rng = np.random.default_rng(1)
    grid = np.array(np.meshgrid([-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0])).reshape(2, -1)
    heading = rng.uniform(-3.0, 3.0, (3, 1, 9))
    ahead = np.concatenate([np.cos(heading), np.sin(heading)], axis=1)
    poses = np.concatenate([0.23 * grid - 0.05 * ahead, heading], axis=1)
    poses[0, :2, 0] = poses[0, :2, 1]  # overlapping: a single certificate answers
    for wish in (ToGoals(np.zeros((3, 2, 9))), Hold(rng.uniform(-0.1, 0.1, (3, 2, 9)))):
        arenas = [BatchArena(poses, engine="numba"), BatchArena(poses, engine="numpy")]
        one, other = (
            rollout(arena, BatchCertificate(certificate, engine=engine), wish, 25)
            for arena, engine in zip(arenas, ("numba", "numpy"), strict=True)
        )
        np.testing.assert_allclose(arenas[0].poses, arenas[1].poses, rtol=0, atol=1e-9)
        np.testing.assert_array_equal(one.statuses, other.statuses)
        for name in ("violation", "intervention", "clearance"):
            np.testing.assert_allclose(getattr(one, name), getattr(other, name), atol=1e-9)
        apart = [arena.violations.smallest_distance for arena in arenas]
        np.testing.assert_allclose(*apart, atol=1e-9)
        assert 0 < one.handed_over < 75
        assert arenas[0].steps == arenas[1].steps == 25


@pytest.mark.parametrize("engine", ENGINES)
def test_a_rollout_goes_on_where_it_stood_and_tells_of_all_its_steps(engine: str) -> None:
    certificate = UnicycleCertificate(0.2, 2000.0, speed_limit=0.15, time_step=0.033)
    poses = starts()[2:]  # in one team two overlap
    wish = ToGoals(-poses[:, :2])
    whole, arena = BatchArena(poses, engine=engine), BatchArena(poses, engine=engine)
    expected = rollout(whole, BatchCertificate(certificate, engine=engine), wish, 12)
    way = Rollout(arena, BatchCertificate(certificate, engine=engine), wish)
    for steps in (1, 1, 10):
        before = way.outcome
        way.run(steps)
        assert before.statuses.sum() + steps * len(poses) == way.outcome.statuses.sum()
    np.testing.assert_array_equal(arena.poses, whole.poses)
    for name in ("statuses", "violation", "intervention", "clearance", "handed_over"):
        np.testing.assert_array_equal(getattr(way.outcome, name), getattr(expected, name))
    with pytest.raises(CommandError, match=r"wish is of shape \(3, 2, 5\); expected \(2, 2, 5\)"):
        Rollout(arena, BatchCertificate(certificate), ToGoals(np.zeros((3, 2, 5))))
    for go in (way.run, arena.run):
        with pytest.raises(CommandError, match="steps: got -1; expected 0 or more"):
            go(-1)
    assert arena.steps == 12


def test_parts_side_by_side_are_the_whole() -> None:
    poses = np.tile(starts(), (32, 1, 1))
    commands = np.random.default_rng(0).uniform(-0.2, 0.2, (len(poses), 2, ROBOTS))
    arenas = [BatchArena(poses, threads=threads) for threads in (1, 3)]
    for arena in arenas:
        arena.commands = commands
        arena.run(40)
    np.testing.assert_array_equal(arenas[0].poses, arenas[1].poses)
    np.testing.assert_array_equal(
        arenas[0].violations.close_by_robot, arenas[1].violations.close_by_robot
    )


def test_what_makes_no_sense_is_refused() -> None:
    with pytest.raises(InitialConditionsError, match=r"expected \(B, 3, N\)"):
        BatchArena(np.zeros((3, 9)))
    with pytest.raises(CommandError, match="seeds: got none; expected 4"):
        BatchArena(starts(), realism=load_profile("gritsbot_x"))
    with pytest.raises(CommandError, match="realism: got 2 profiles; expected one, or 4"):
        BatchArena(starts(), realism=DRAWN[:2], seeds=range(TEAMS))

    with pytest.raises(CommandError, match="got 1 objects for 4 teams; expected one of its own"):
        BatchArena(starts(), realism=[Fading()] * TEAMS, seeds=range(TEAMS))
    with pytest.raises(CommandError, match="got 3 profiles; expected one, or 4"):
        BatchArena(starts(), realism=[Fading(), Fading(), Fading()], seeds=range(TEAMS))
    arena = BatchArena(starts())
    arena.commands = np.zeros((2, ROBOTS))
    with pytest.raises(CommandError, match=r"need \(4, 2, 5\)"):
        arena.step()
    arena.commands = np.full((TEAMS, 2, ROBOTS), 0.1)
    arena.commands[2, 1, 3] = np.nan
    with pytest.raises(CommandError, match="team 2: the turn rate of robot 3 is nan"):
        arena.step()
    np.testing.assert_array_equal(arena.poses, starts())


@pytest.mark.parametrize("engine", ENGINES)
def test_teams_that_begin_anew_are_as_if_they_had_just_begun(engine: str) -> None:
    arena = BatchArena(starts(), engine=engine)
    arena.commands = np.full((TEAMS, 2, ROBOTS), 0.1)
    arena.run(20)
    others = arena.poses[[0, 3]].copy()
    arena.restart([1, 2], starts()[[2, 1]])
    fresh = BatchArena(starts()[[2, 1]], engine=engine)
    np.testing.assert_array_equal(arena.poses[[1, 2]], fresh.poses)
    np.testing.assert_array_equal(arena.poses[[0, 3]], others)
    arena.run(10)  # the others go on with their commands, these stand
    fresh.run(10)
    assert (arena.poses[[0, 3]] != others).any()
    np.testing.assert_array_equal(arena.poses[[1, 2]], fresh.poses)
    for counter in COUNTERS:
        ours, theirs = getattr(arena.violations, counter), getattr(fresh.violations, counter)
        np.testing.assert_array_equal(ours[[1, 2]], theirs)
    with pytest.raises(InitialConditionsError, match=r"\(1, 3, 5\)"):
        arena.restart([0], starts())
    real = BatchArena(starts(), realism=load_profile("gritsbot_x"), seeds=range(TEAMS))
    with pytest.raises(CommandError, match="make another BatchArena"):
        real.restart([0], starts()[:1])
