"""Runs of different parameters in one call: the same rows, each with an end of its own."""

import csv
from pathlib import Path

import pytest
from typer.testing import CliRunner

from posflock_robotarium.cli import app
from posflock_robotarium.sweep import robots
from posflock_robotarium.sweep.execution import batches, compute, execute, locally
from posflock_robotarium.sweep.experiments import Experiment, Outcome, register
from posflock_robotarium.sweep.results import engines, finished, outcomes
from posflock_robotarium.sweep.store import ENGINE, ERROR, Row, Store
from posflock_robotarium.sweep.study import parse_study, read_study

CALLS: list[list[int]] = []


def square(values: list[int]) -> list[Outcome]:
    CALLS.append(values)
    if 7 in values:
        raise ValueError("no sevens")
    return [{"square": float(value**2)} for value in values]


register(
    Experiment(
        "mixed-for-test",
        "",
        {"value": 0, "kind": "odd"},
        lambda parameters, seeds: square([parameters["value"]] * len(seeds)),
        ("square",),
        together=32,
        run_mixed=lambda parameters, seeds: square([one["value"] for one in parameters]),
        alike=lambda parameters: parameters["kind"],
        engine=lambda parameters: "numba" if parameters["value"] % 2 else "numpy",
    )
)
GRID = {"value": list(range(20)), "kind": ["odd", "even"]}
MIXED = parse_study({"experiment": "mixed-for-test", "replications": 1, "grid": GRID})
#: A wide draw of the law, under three profiles, from starts of two sizes: all of it differs.
ROBOTS = parse_study(
    {
        "experiment": "robots",
        "replications": 2,
        "parameters": {"duration": 0.8, "robots": 4},
        "grid": {"profile": ["ideal", "gritsbot_x", "harsh"], "side": [1.0, 1.2]},
        "distributions": {
            "radius": {"uniform": [0.5, 0.9]},
            "persistence": {"uniform": [1.0, 4.0]},
            "speed_limit": {"uniform": [0.1, 0.15]},
        },
    }
)


def said(row: Row) -> str:
    """Return what a row says of its run, numbers in full; NaN is NaN."""
    return repr({name: value for name, value in row.items() if name != "seconds"})


@pytest.mark.parametrize(("workers", "sizes"), [(1, [20] * 2), (2, [10] * 4), (9, [8, 8, 4] * 2)])
def test_runs_go_together_by_what_they_must_share_and_leave_no_worker_idle(
    workers: int, sizes: list[int]
) -> None:
    made = batches(MIXED.runs(), MIXED.experiment, workers)
    assert [len(batch) for batch in made] == sizes
    assert all(len({run.parameters["kind"] for run in batch}) == 1 for batch in made)
    runs = sorted(run.key for batch in made for run in batch)
    assert runs == sorted(run.key for run in MIXED.runs())


def test_a_run_that_fails_takes_few_of_its_company_with_it() -> None:
    (odd, _) = batches(MIXED.runs(), MIXED.experiment)
    CALLS.clear()
    rows = compute("mixed-for-test", odd)
    assert [row.get("square") for row in rows] == [None if v == 7 else v**2 for v in range(20)]
    assert rows[7][ERROR] == "ValueError: no sevens"
    assert len(CALLS) < 12  # halves of halves, not run by run


def test_robots_of_any_law_and_kind_are_in_company_what_they_are_alone() -> None:
    made = batches(ROBOTS.runs(), ROBOTS.experiment)
    assert [len(batch) for batch in made] == [4, 8]  # the ideal ones by themselves
    for batch in made:
        together = compute("robots", batch)
        alone = [row for run in batch for row in compute("robots", [run])]
        assert list(map(said, together)) == list(map(said, alone))  # to the last bit
        assert len({row["mean_speed"] for row in together}) == len(batch)


def test_robots_share_how_many_they_are_how_long_they_drive_and_what_holds_them() -> None:
    must = {"robots": [3, 4], "duration": [0.4, 0.5], "walls": ["steer", "certificate"]}
    may = {"profile": ["gritsbot_x", "harsh"], "radius": [0.7, 0.8]}
    study = parse_study({"experiment": "robots", "replications": 1, "grid": must | may})
    made = batches(study.runs(), study.experiment)
    assert [len(batch) for batch in made] == [4] * 8
    for batch in made:
        assert len({tuple(run.parameters[name] for name in must) for run in batch}) == 1


def test_a_row_says_who_computed_it_and_a_sweep_by_whom_all_were(tmp_path: Path) -> None:
    with Store(tmp_path / "store") as store:
        execute(MIXED, store, locally(1))
        rows = finished(MIXED, store)
    assert engines(MIXED, rows) == {"numpy": 20, "numba": 18}  # nobody computed a 7
    assert outcomes(MIXED, rows) == ["square"]


def test_who_computes_robots_hangs_on_numba_and_on_how_long_they_drive(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = {"duration": 9.0}
    assert robots._engine(asked) == "numpy"
    for installed, engine in ((True, "numba"), (False, "numpy")):
        monkeypatch.setattr(robots, "numba_is_installed", lambda there=installed: there)
        assert robots._engine(asked | {"duration": 10.0}) == engine


def test_a_study_that_two_engines_computed_is_told(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(
        'experiment = "robots"\nreplications = 1\n[parameters]\nrobots = 2\nduration = 0.4\n'
        "[grid]\nradius = [0.7, 0.8]\n"
    )
    one, other = compute("robots", read_study(path).runs())
    with Store(tmp_path / "out" / "store") as store:
        store.append([one, other | {ENGINE: "numba"}])
    done = CliRunner().invoke(app, ["sweep", str(path), "-o", str(tmp_path / "out")])
    assert done.exit_code == 0
    assert "1 by numba and 1 by numpy: their last bits differ" in done.output
    with (tmp_path / "out" / "results.csv").open() as file:
        assert [line[ENGINE] for line in csv.DictReader(file)] == ["numpy", "numba"]
