"""Graph Laplacians, neighbours, starting places and arrival tests."""

import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rps_compat import deviations
from rps_compat.arguments import AgentError, NotAnArrayError, NumberError, ShapeError
from rps_compat.placement import CrowdedError
from rps_compat.v1.utilities import graph as first
from rps_compat.v1.utilities import misc as first_misc
from rps_compat.v2.utilities import graph as second
from rps_compat.v2.utilities import misc as second_misc

NODES = st.integers(3, 15)


@given(NODES, st.integers(0, 30), st.integers(0, 2**31 - 1))
def test_laplacians_are_symmetric_and_their_rows_sum_to_zero(nodes, edges, seed):
    np.random.seed(seed)  # noqa: NPY002
    for laplacian in (
        first.cycle_GL(nodes),
        second.lineGL(nodes),
        first.completeGL(nodes),
        second.randomGL(nodes, edges),
        first.random_connectedGL(nodes, edges),
    ):
        np.testing.assert_array_equal(laplacian, laplacian.T)
        np.testing.assert_array_equal(laplacian.sum(axis=1), 0)
        assert set(laplacian[~np.eye(nodes, dtype=bool)]) <= {0.0, -1.0}


@given(NODES, st.integers(0, 30), st.integers(0, 2**31 - 1))
def test_random_graphs_have_the_edges_asked_for(nodes, extra, seed):
    np.random.seed(seed)  # noqa: NPY002
    every = nodes * (nodes - 1) // 2
    connected = second.random_connectedGL(nodes, extra)
    assert np.trace(connected) == 2 * min(nodes - 1 + extra, every)
    # Connected exactly if the second smallest eigenvalue is positive (Fiedler 1973).
    assert np.linalg.eigvalsh(connected)[1] > 1e-9
    assert np.trace(second.randomGL(nodes, extra)) == 2 * min(extra, every)


def test_random_graphs_follow_the_published_stream():
    np.random.seed(0)  # noqa: NPY002
    joined = [(0, 1), (0, 2), (0, 3), (0, 4), (1, 2), (1, 3), (1, 4)]
    expected = np.zeros((5, 5))
    for i, j in joined:
        expected[[i, j], [j, i]] = -1
        expected[[i, j], [i, j]] += 1
    np.testing.assert_array_equal(first.random_connectedGL(5, 3), expected)


@pytest.mark.parametrize("generation", [first, second])
def test_neighbours_of_a_line_and_of_a_disk(generation):
    line = generation.lineGL(4)
    assert generation.topological_neighbors(line.copy(), 0).tolist() == [1]
    assert generation.topological_neighbors(line.copy(), 2).tolist() == [1, 3]
    poses = np.array([[0.0, 0.3, 0.0, 0.31], [0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 2.0, 3.0]])
    assert generation.delta_disk_neighbors(poses, 0, 0.3).tolist() == [1, 2]


def test_only_generation_1_empties_the_diagonal_as_published():
    line = first.lineGL(3)
    first.topological_neighbors(line, 1)
    assert np.diag(line).tolist() == [1, 0, 1]
    line = second.lineGL(3)
    second.topological_neighbors(line, 1)
    assert np.diag(line).tolist() == [1, 2, 1]


@pytest.mark.parametrize("generation", [first, second])
def test_unknown_agents_are_refused(generation):
    for agent in (-1, 3, 1.5, None):
        with pytest.raises(AgentError, match="expected an int from 0 to 2"):
            generation.topological_neighbors(generation.lineGL(3), agent)
    with pytest.raises(NotAnArrayError):
        generation.delta_disk_neighbors([[0.0], [0.0]], 0, 1.0)
    with pytest.raises(ShapeError):
        generation.topological_neighbors(np.zeros(3), 0)


@pytest.mark.parametrize("nodes", [0, -1, 2.0, "a", None, True, np.int64(4)])
def test_graphs_of_no_size_are_refused(nodes):
    for create in (first.cycle_GL, first.lineGL, second.completeGL, second.cycleGL):
        with pytest.raises(NumberError, match="expected an int >="):
            create(nodes)


@given(st.integers(1, 9), st.integers(0, 2**31 - 1))
def test_random_places_keep_their_distance_and_stay_inside(robots, seed):
    np.random.seed(seed)  # noqa: NPY002
    for poses, spacing in (
        (first_misc.generate_initial_conditions(robots, 0.3, 3, 1.8), 0.3),
        (second_misc.generate_random_poses(robots, 0.4, 3.0, 1.8), 0.4),
    ):
        assert poses.shape == (3, robots)
        offsets = poses[:2, :, None] - poses[:2, None, :]
        apart = np.hypot(*offsets)[np.triu_indices(robots, 1)]
        assert np.all(apart >= spacing)
        assert np.all(np.abs(poses[:2]) <= [[1.5], [0.9]])
        assert np.all(np.abs(poses[2]) <= np.pi)


def test_random_places_follow_the_published_stream():
    np.random.seed(0)  # noqa: NPY002
    expected = np.random.rand(2) - 0.5  # noqa: NPY002
    np.random.seed(0)  # noqa: NPY002
    first_place = first_misc.generate_initial_conditions(3)[:2, 0]
    np.testing.assert_allclose(first_place, expected * [3, 1.8])
    random.seed(0)
    slot = random.sample(range(22), 1)[0]
    random.seed(0)
    x, y, heading = second_misc.generate_initial_poses(1)[:, 0]
    assert x == pytest.approx(-1.5 + 0.3 * (slot // 2))
    assert y == (0.5 if slot % 2 else -0.5)
    assert heading == -np.sign(y) * np.pi / 2  # looks at the other row


def test_too_many_robots_are_refused_with_the_room_there_is():
    with pytest.raises(CrowdedError, match="there is room for 60"):
        first_misc.generate_initial_conditions(61)
    with pytest.raises(CrowdedError, match=r"found a place 0\.3 m from the others in 200 draws"):
        first_misc.generate_initial_conditions(60)
    with pytest.raises(ValueError, match="larger than population"):
        second_misc.generate_initial_poses(23)


@pytest.mark.parametrize("off", [0.0, 2 * np.pi, -2 * np.pi])
def test_arrival_wraps_angles(off):
    states = np.array([[0.0, 0.0, 0.0], [0.0, 0.06, 0.0], [np.pi - 0.01, 0.0, 1.0]])
    goals = np.zeros((3, 3))
    goals[2] = [-np.pi + 0.01, 0.0, 0.0]
    goals[2] += off
    assert [indices.tolist() for indices in first_misc.at_pose(states, goals)] == [[0]]
    everybody, each = second_misc.create_at_pose()(states, goals)
    assert everybody is False
    assert each.tolist() == [True, False, False]


def test_arrival_at_positions():
    states = np.array([[0.0, 0.5], [0.0, 0.0], [1.0, 2.0]])
    points = np.array([[0.01, 0.0], [0.0, 0.0]])
    assert [indices.tolist() for indices in first_misc.at_position(states, points)] == [[0]]
    assert second_misc.create_at_position()(states, points)[1].tolist() == [True, False]
    assert second_misc.create_at_position()(np.zeros((3, 0)), np.zeros((2, 0)))[0] is True
    with deviations.all_as_published(), pytest.raises(NameError):
        first_misc.at_position(states, points)


def test_rotation_matrices_turn_vectors():
    angles = np.array([0.0, np.pi / 2, np.pi])
    turned = np.einsum("ijm,j->im", second_misc.rotation_matrix(angles), [1.0, 0.0, 0.0])
    np.testing.assert_allclose(turned, [[1, 0, -1], [0, 1, 0], [0, 0, 0]], atol=1e-12)


class Figureless:
    show_figure = False


def test_sizes_in_a_figure_that_is_not_there():
    assert first_misc.determine_marker_size(Figureless(), 0.1) == pytest.approx(52.1**2)
    assert first_misc.determine_font_size(Figureless(), 0.1) == pytest.approx(11.55)
    with pytest.raises(second_misc.NoFigureError, match="show_figure=False") as caught:
        second_misc.determine_font_size(Figureless(), 0.1)
    assert isinstance(caught.value, AttributeError)
