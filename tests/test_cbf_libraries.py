"""What the comparison with other libraries tells of answers is true of them."""

from pathlib import Path

import numpy as np
import pytest

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"


@pytest.fixture
def comparison(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import cbf_libraries

    return cbf_libraries


@pytest.fixture
def packed(comparison):
    """Recorded states in which rows bind, and our answers to them."""
    states = comparison.record("packed", 2)
    ours = comparison.Ours(comparison.BOX, {"packed": states})
    ours.round("packed")
    return ours, states


def test_exact_answers_break_nothing_and_have_no_error(comparison, packed):
    ours, states = packed
    told = comparison.judged(ours, "packed", states)
    assert told.broken < 1e-6
    assert told.largest_error < 1e-6
    assert told.silent == 0.0
    assert comparison.doubt(comparison.BOX, states) < 1e-9


def test_the_wish_itself_breaks_rows_by_what_it_is_off(comparison, packed):
    ours, (wishes, at) = packed
    exact = ours.answers["packed"].copy()
    ours.answers["packed"] = wishes.reshape(exact.shape)
    told = comparison.judged(ours, "packed", (wishes, at))
    assert told.broken > 10.0  # mm/s
    off = np.hypot(*np.moveaxis(wishes.reshape(exact.shape) - exact, 1, 0)).max(axis=1)
    assert told.largest_error == pytest.approx(1e3 * off.max())


def test_what_stands_still_is_safe_but_off_the_optimum(comparison, packed):
    ours, states = packed
    ours.answers["packed"] = np.zeros_like(ours.answers["packed"])
    told = comparison.judged(ours, "packed", states)
    assert told.broken == 0.0
    assert told.error > 1.0


def test_no_answer_is_told_and_not_counted_as_an_error(comparison, packed):
    ours, states = packed
    ours.answers["packed"][0, 0, 0] = np.nan
    told = comparison.judged(ours, "packed", states)
    assert told.silent == pytest.approx(1 / len(ours.answers["packed"]))
    assert told.largest_error < 1e-6


def test_an_answer_that_is_not_the_nearest_leaves_doubt(comparison, packed, monkeypatch):
    _, states = packed
    certificate = comparison.certificate

    class Short:
        """Certifies half of what is exact: safe, and not the nearest."""

        def __init__(self, limits):
            self._exact = certificate(limits)

        def __call__(self, wish, at):
            velocity, info = self._exact(wish, at)
            return 0.5 * velocity, info

    monkeypatch.setattr(comparison, "certificate", Short)
    assert comparison.doubt(comparison.BOX, states) > 1e-3


def test_all_candidates_of_an_environment_are_asked(comparison, tmp_path):
    asked = comparison.argparse.Namespace(
        cbfpy=tmp_path, cbfkit=None, cbfjax=None, rps=None, only=None
    )
    names = [name for name, _ in comparison.asked_for(asked)]
    assert names == ["cbfpy", "cbfpy-hard", "cbfpy-elastiqp"]
