"""Robots that are taken for each other: nothing is lost to the team, and it is undone as asked."""

import numpy as np
import pytest
from rolling_robots import rolling
from typer.testing import CliRunner

from posflock_robotarium.cli import app
from posflock_robotarium.logs.plausibility import sightings_of, without_exchanges
from posflock_robotarium.report import ReadOptions, Run, analyse, read

ROWS = 300
T, POSES = rolling(ROWS, 5)


def exchanged(rows, there):
    poses = POSES.copy()
    poses[rows, :, : len(there)] = poses[rows][:, :, there]
    return Run("run", T, poses)


CASES = {
    "for good": (slice(150, None), [1, 0], [False]),
    "for a while": (slice(100, 200), [1, 0], [False, True]),
    "three in a circle": (slice(150, None), [1, 2, 0], [False]),
    "two pairs at once": (slice(150, None), [1, 0, 3, 2], [False]),
}


@pytest.mark.parametrize("name", CASES)
def test_exchanges_are_found_and_undone(name):
    rows, there, mended = CASES[name]
    run = exchanged(rows, there)
    found = sightings_of(run, run.t)
    assert found.placed.all()
    assert [exchange.mended for exchange in found.exchanges] == mended
    assert found.exchanges[0].row == rows.start
    np.testing.assert_array_equal(without_exchanges(run).poses, POSES)


@pytest.mark.parametrize("name", CASES)
def test_the_team_loses_nothing(name):
    rows, there, _ = CASES[name]
    numbers = analyse(exchanged(rows, there), radius=2.0).numbers
    sound = analyse(Run("run", T, POSES), radius=2.0).numbers
    for key in ("gamma_motion", "speed", "smallest_distance", "collisions", "noise_position"):
        assert numbers[key].value == pytest.approx(sound[key].value, abs=1e-9), key


def test_it_is_proposed_and_done_only_when_asked(tmp_path):
    run = exchanged(slice(150, None), [1, 0])
    path = tmp_path / "run.npz"
    np.savez(path, t=run.t, poses=run.poses)
    np.testing.assert_array_equal(read(path).poses, run.poses)
    words = ["report", str(path), "--radius", "2", "--no-figures", "-o", str(tmp_path / "out")]
    output = " ".join(CliRunner().invoke(app, words).output.split())
    assert "Robots 0 and 1 are taken for each other from 5.0 s on." in output
    assert "--fix-swaps" in output
    fixed = read(path, ReadOptions(fix_swaps=True))
    np.testing.assert_array_equal(fixed.poses, POSES)
    assert any("undone, as asked: robots 0 and 1" in note for note in fixed.notes)
    output = CliRunner().invoke(app, [*words, "--fix-swaps"]).output
    assert "taken for each other" not in output


def test_commands_stay_with_the_robots_that_they_were_sent_to():
    run = exchanged(slice(150, None), [1, 0])
    commands = np.zeros((ROWS, 2, 5))
    commands[:, 0] = np.arange(5)
    told = without_exchanges(Run("run", T, run.poses, commands))
    np.testing.assert_array_equal(told.commands, commands)


def test_without_an_exchange_nothing_is_undone():
    assert "nothing to undo" in without_exchanges(Run("run", T, POSES)).notes[-1]
