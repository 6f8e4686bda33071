"""Point agents: the plain law written out, batches, k-d trees, imperfect sensing."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.metrics import connectivity, directions, distances
from posflock_robotarium.alignment.point_agents import measure, summarise
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import (
    PAPER_SIMULATION,
    LawParameters,
    displacements,
    neighbours,
    position_based_input,
    velocity_based_input,
)
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.freespace.neighbour_search import (
    TREE_FROM_AGENTS,
    nearest_distances,
    neighbour_pairs,
    position_based_input_over,
    velocity_based_input_over,
)
from posflock_robotarium.freespace.sensing import Sensing
from posflock_robotarium.freespace.simulation import FreeSpace, simulate, simulate_batch

SHORT = FreeSpace(agents=12, side=12.0, duration=3.0, record_interval=0.05)


def written_out(scenario, p, v):
    """The specification agent by agent, in plain Python: one run, every step's positions."""
    law, n, d = scenario.law, scenario.agents, scenario.dimensions
    first, path, dt = p.copy(), [p.copy()], scenario.time_step

    def saturated(x, limit):
        norm = math.sqrt(sum(c * c for c in x))
        return [0.0] * d if norm == 0 else [limit * math.tanh(norm / limit) * c / norm for c in x]

    for step in range(1, scenario.steps + 1):
        t, inputs = step * dt, []
        for i in range(n):
            near = [j for j in range(n) if j != i and math.dist(p[:, i], p[:, j]) < law.radius]
            count, u = len(near), [0.0] * d
            if scenario.model is Model.POSITION and t > 1.0 / law.persistence:
                phi = law.persistence * count
            else:
                phi = count / t
            for j in near:
                psi = 1.0 - law.distance_scale * count / math.dist(p[:, i], p[:, j])
                for c in range(d):
                    offset = p[c, j] - p[c, i]
                    if scenario.model is Model.VELOCITY:
                        u[c] += psi * offset + v[c, j] - v[c, i]
                    else:
                        u[c] += (psi + phi) * offset - phi * (first[c, j] - first[c, i])
            inputs.append(saturated(u, law.input_limit))
        v = np.array(
            [
                saturated([v[c, i] + dt * inputs[i][c] for c in range(d)], law.speed_limit)
                for i in range(n)
            ]
        ).T
        p = p + dt * v
        path.append(p)
    return np.array(path)


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("model", Model)
def test_a_run_is_the_specification_written_out(model, dimensions):
    law = replace(PAPER_SIMULATION, persistence=0.5)  # so that 3 s reach past the threshold
    scenario = replace(SHORT, model=model, dimensions=dimensions, law=law)
    run = simulate(scenario, seed=5)
    expected = written_out(scenario, run.positions[0], run.velocities[0])
    np.testing.assert_allclose(run.positions, expected, rtol=0, atol=1e-10)


@pytest.mark.parametrize("model", Model)
def test_a_flock_in_a_batch_is_the_flock_alone(model):
    scenario = FreeSpace(model=model, duration=20.0)
    seeds = [*range(11), 3]  # more than advance together, and one twice
    batch = simulate_batch(scenario, seeds)
    for flock, seed in enumerate(seeds[::5]):
        alone = simulate(scenario, seed)
        np.testing.assert_array_equal(batch[5 * flock].positions, alone.positions)
        np.testing.assert_array_equal(batch[5 * flock].velocities, alone.velocities)
    np.testing.assert_array_equal(batch[3].positions, batch[11].positions)
    assert not np.array_equal(batch[0].positions, batch[1].positions)


def test_noisy_flocks_too_are_the_same_alone_and_in_a_batch():
    sensing = Sensing(position_noise=0.05, velocity_noise=0.1, dropout=0.2, delay=0.1, failing=0.3)
    scenario = replace(SHORT, model=Model.VELOCITY, sensing=replace(sensing, failure_time=1.0))
    batch = simulate_batch(scenario, range(4))
    np.testing.assert_array_equal(batch[2].positions, simulate(scenario, 2).positions)
    np.testing.assert_array_equal(batch[2].failing, simulate(scenario, 2).failing)


def test_models_start_identically_and_a_seed_is_a_run():
    runs = [simulate(replace(SHORT, model=model), seed=4) for model in Model]
    for run in runs[1:]:
        np.testing.assert_array_equal(run.positions[0], runs[0].positions[0])
        np.testing.assert_array_equal(run.velocities[0], runs[0].velocities[0])
    np.testing.assert_array_equal(simulate(SHORT, 4).positions, runs[1].positions)
    assert (np.abs(runs[0].positions[0] - 6.0) <= 6.0).all()
    assert np.linalg.norm(runs[0].velocities[0], axis=0).max() <= 1.0


@given(
    seed=st.integers(0, 10_000),
    dimensions=st.sampled_from([2, 3]),
    each=st.booleans(),
    together=st.integers(0, 3),
)
def test_the_tree_gives_the_dense_law(seed, dimensions, each, together):
    generator = np.random.default_rng(seed)
    n = 40
    p = generator.uniform(0.0, 20.0, (dimensions, n))
    p[:, :together] = p[:, -1:]  # coincident agents
    v = generator.normal(size=p.shape)
    first = generator.uniform(0.0, 20.0, p.shape)
    law = (
        LawParameters(
            distance_scale=generator.uniform(0.1, 1.0, n),
            radius=generator.uniform(2.0, 9.0, n),
            persistence=0.1,
            speed_limit=generator.uniform(1.0, 3.0, n),
            input_limit=5.0,
        )
        if each
        else PAPER_SIMULATION
    )
    pairs = neighbour_pairs(p, law.radius)
    marked = np.zeros((n, n), dtype=bool)
    marked[pairs.agent, pairs.other] = True
    np.testing.assert_array_equal(marked, neighbours(p, law.radius))
    np.testing.assert_allclose(
        velocity_based_input_over(pairs, p, v, law), velocity_based_input(p, v, law), atol=1e-10
    )
    for threshold in (True, False):
        np.testing.assert_allclose(
            position_based_input_over(pairs, p, first, 20.0, law, threshold=threshold),
            position_based_input(p, displacements(first), 20.0, law, threshold=threshold),
            atol=1e-10,
        )


def test_a_pair_exactly_at_the_radius_is_no_pair():
    p = np.array([[0.0, 7.5, -3.0], [0.0, 0.0, 0.0]])
    pairs = neighbour_pairs(p, 7.5)
    assert set(zip(pairs.agent.tolist(), pairs.other.tolist(), strict=True)) == {(0, 2), (2, 0)}


@pytest.mark.parametrize("model", Model)
def test_a_large_flock_runs_by_tree_as_it_would_densely(model, monkeypatch):
    scenario = FreeSpace(model=model, agents=TREE_FROM_AGENTS, side=61.0, duration=1.0)
    by_tree = simulate(scenario, 1)
    monkeypatch.setattr("posflock_robotarium.freespace.simulation.TREE_FROM_AGENTS", 10_000)
    np.testing.assert_allclose(by_tree.positions, simulate(scenario, 1).positions, atol=1e-10)


@given(seed=st.integers(0, 1000))
def test_metrics_by_tree_are_the_dense_metrics(seed):
    generator = np.random.default_rng(seed)
    p = generator.uniform(0.0, 12.0, (2, 3, 2, 30))
    v = generator.normal(size=p.shape) * (generator.random((2, 3, 1, 30)) > 0.2)
    radius = generator.uniform(1.0, 3.0, 30)
    measures = {
        "gamma": lambda: metrics.alignment(v, p, radius).gamma,
        "counted": lambda: metrics.alignment(v, p, radius).counted,
        "nearest": lambda: metrics.nearest_neighbour_distance(p),
        "closest": lambda: metrics.smallest_distance(p),
        "components": lambda: metrics.connected_components(p, radius),
    }
    dense = {name: value() for name, value in measures.items()}
    with pytest.MonkeyPatch.context() as patch:
        for module in (directions, distances, connectivity):
            patch.setattr(module, "TREE_FROM_AGENTS", 2)
        for name, value in measures.items():
            np.testing.assert_allclose(value(), dense[name], atol=1e-10, err_msg=name)
    np.testing.assert_allclose(nearest_distances(p[0, 0]).mean(), dense["nearest"][0, 0])


def test_everyone_missed_is_everyone_alone():
    """With every neighbour missed there is no input, and velocities only saturate."""
    blind = simulate(replace(SHORT, sensing=Sensing(dropout=1.0)), 3)
    direction = blind.velocities / np.linalg.norm(blind.velocities, axis=1, keepdims=True)
    np.testing.assert_allclose(direction, np.broadcast_to(direction[0], direction.shape))


def test_a_delay_of_nothing_is_no_delay_and_a_delay_changes_the_run():
    plain = simulate(SHORT, 3).positions
    prompt = simulate(replace(SHORT, sensing=Sensing(delay=0.0)), 3).positions
    np.testing.assert_array_equal(prompt, plain)
    late = simulate(replace(SHORT, sensing=Sensing(delay=0.5)), 3).positions
    # Until the first old state differs from the first state, both sense the same.
    np.testing.assert_array_equal(late[1], plain[1])
    assert np.abs(late[-1] - plain[-1]).max() > 1e-3


def test_noise_has_the_size_that_was_asked_for():
    """A lone pair out of reach feels nothing; one in reach feels what is sensed, first step."""
    scenario = replace(SHORT, agents=2, side=0.1, fastest_start=0.0, duration=0.05)
    noisy = replace(scenario, model=Model.VELOCITY, sensing=Sensing(velocity_noise=0.01))
    quiet = replace(scenario, model=Model.VELOCITY)
    seeds = range(300)
    pushes = (
        simulate_batch(noisy, seeds).velocities[:, -1]
        - simulate_batch(quiet, seeds).velocities[:, -1]
    ) / scenario.time_step
    # u_i = … + (v_j − v_i): the difference of two errors of 0.01 m/s.
    assert pushes.std() == pytest.approx(0.01 * math.sqrt(2.0), rel=0.1)


@pytest.mark.parametrize("failure", ["stop", "vanish"])
def test_failed_agents_stand_still_and_are_not_measured(failure):
    sensing = Sensing(failing=0.25, failure_time=1.0, failure=failure)
    run = simulate(replace(SHORT, sensing=sensing), 2)
    assert run.failing.sum() == 3
    after = run.times >= 1.0 - 1e-9
    assert (run.velocities[after][:, :, run.failing] == 0.0).all()
    assert (run.velocities[after][:, :, ~run.failing] != 0.0).any()
    survivors = metrics.mean_speed(run.velocities[..., ~run.failing])
    np.testing.assert_allclose(measure(run, 7.5).speed, survivors)


def test_vanished_agents_push_no_one():
    both = [
        simulate(
            replace(
                SHORT,
                agents=2,
                side=2.0,
                fastest_start=0.0,
                sensing=Sensing(failing=0.5, failure_time=0.0, failure=failure),
            ),
            1,
        )
        for failure in ("stop", "vanish")
    ]
    stopped, vanished = (np.abs(run.velocities[:, :, ~run.failing]).max() for run in both)
    assert vanished == 0.0 < stopped


def test_measures_of_a_batch_are_those_of_its_flocks():
    batch = simulate_batch(SHORT, range(3))
    together, alone = measure(batch, 7.5), measure(batch[1], 7.5)
    for name in ("gamma", "nearest_neighbour", "change_variance", "components"):
        np.testing.assert_array_equal(getattr(together, name)[1], getattr(alone, name))
    numbers = summarise(together)
    assert {np.shape(value) for value in numbers.values()} == {(3,)}
    for name, value in summarise(alone).items():
        assert value == numbers[name][1], name


def test_the_closed_forms_of_the_summary():
    run = simulate(replace(SHORT, duration=10.0), 0)
    measures = measure(run, 7.5)
    numbers = summarise(measures)
    aligned = measures.gamma >= 0.9
    first = measures.times[aligned][0] if aligned.any() else math.inf
    assert numbers["alignment_time"] == first
    assert numbers["gamma_settled"] == pytest.approx(measures.gamma[measures.times >= 2.0].mean())
    headings = measures.centroid_velocity[measures.times >= 2.0]
    angles = np.unwrap(np.arctan2(headings[:, 1], headings[:, 0]))
    assert numbers["heading_spread"] == pytest.approx(min(180.0, np.degrees(np.ptp(angles))))


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"model": "boids"}, "velocity, position"),
        ({"agents": 1}, "from 2"),
        ({"agents": 2.5}, "whole number"),
        ({"dimensions": 4}, "2 or 3"),
        ({"time_step": 0.0}, "more than zero"),
        ({"duration": math.nan}, "more than zero"),
        ({"duration": 0.01}, "at least one time step"),
        ({"duration": 0.1}, "at most the duration"),
        ({"fastest_start": -1.0}, "zero or more"),
        ({"law": replace(PAPER_SIMULATION, radius=np.ones(3))}, "3"),
    ],
)
def test_a_scenario_that_means_nothing_is_refused(wrong, said):
    with pytest.raises(ParameterError, match=said):
        replace(FreeSpace(), **wrong)


@pytest.mark.parametrize(
    "wrong",
    [
        {"dropout": 1.5},
        {"failing": 1.0},
        {"position_noise": -0.1},
        {"delay": math.inf},
        {"failure": "explode"},
    ],
)
def test_sensing_that_means_nothing_is_refused(wrong):
    with pytest.raises(ParameterError, match=next(iter(wrong))):
        Sensing(**wrong)


def test_no_seeds_are_refused():
    with pytest.raises(ParameterError, match="at least one"):
        simulate_batch(SHORT, [])
