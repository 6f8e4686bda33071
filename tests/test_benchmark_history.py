"""What benchmarks measured is kept a row a run, and drawn."""

import json
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"


@pytest.fixture
def history(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import history

    return history


def measured(speed):
    from comparing import Table

    table = Table()
    for part in ("generation 1", "generation 2"):
        table.part(part)
        table.bar("a step, against plain numpy", speed, "≤", 2.0, "×")
    return table


@pytest.mark.parametrize(
    ("interval", "verdict", "code"),
    [
        ((1.0, 2.0), "ok", 0),
        ((1.5, 2.5), "not settled", 0),
        ((2.1, 2.5), "MISSED", 1),
        (None, "MISSED", 1),
    ],
)
def test_a_bar_over_seeds_is_judged_by_the_whole_interval(history, capsys, interval, verdict, code):
    from comparing import Table

    table = Table()
    table.bar("a number", 2.2, "≤", 2.0, interval=interval)
    assert table.exit_code() == code
    assert f" {verdict}" in capsys.readouterr().out.splitlines()[0]


def test_rows_are_added_where_that_is_asked_for_and_drawn(history, tmp_path, monkeypatch):
    monkeypatch.delenv(history.VARIABLE, raising=False)
    assert history.recorded("steps", measured(1.5), tmp_path) == 0
    assert not list(tmp_path.iterdir())
    monkeypatch.setenv(history.VARIABLE, "1")
    assert history.recorded("steps", measured(1.5), tmp_path) == 0
    assert history.recorded("steps", measured(2.5), tmp_path) == 1
    monkeypatch.setattr(history, "machine", lambda: "another0")
    history.recorded("steps", measured(float("nan")), tmp_path)  # unknown is absent
    rows = history.read(tmp_path / "steps.jsonl")
    assert [row["figures"] for row in rows] == [
        {f"generation {g}: a step, against plain numpy": value for g in (1, 2)}
        for value in (1.5, 2.5)
    ] + [{}]
    assert set(rows[0]["bars"].values()) == {"≤ 2 ×"}
    assert rows[0]["machine"] == rows[1]["machine"] != rows[2]["machine"]
    assert history.draw("steps", rows, tmp_path / "new").stat().st_size > 10_000


def test_histories_that_are_kept_can_be_read():
    for path in (BENCHMARKS / "history").glob("*.jsonl"):
        assert (BENCHMARKS / f"{path.stem}.py").exists()
        for line in path.read_text(encoding="utf-8").splitlines():
            row = json.loads(line)
            assert set(row["figures"]) <= set(row["bars"])
            assert len(row["machine"]) == 8
