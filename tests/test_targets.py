"""Targets in words: the grammar, its units, and what it refuses."""

import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from posflock_robotarium.alignment.targets import GRAMMAR, Relation, When, parse_target
from posflock_robotarium.flocking.errors import ParameterError


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("e < 0.05 m for 95 % of the time", (Relation.BELOW, 0.05, "m", When.SHARE, 0.95, 0)),
        ("e<5cm", (Relation.BELOW, 5.0, "cm", When.UNSAID, 1.0, 0)),
        ("e ≤ -3 deg always after 20s", (Relation.AT_MOST, -3.0, "deg", When.ALWAYS, 1.0, 20)),
        ("e >= 1e-2 on average", (Relation.AT_LEAST, 0.01, "", When.AVERAGE, 1.0, 0)),
        ("e > .5 J at the end", (Relation.ABOVE, 0.5, "J", When.END, 1.0, 0)),
        ("e > 90% for 50% of the time", (Relation.ABOVE, 90.0, "%", When.SHARE, 0.5, 0)),
    ],
)
def test_what_follows_the_grammar_is_read(text, expected):
    target = parse_target(text)
    assert target.metric == "e"
    read = (target.relation, target.value, target.unit, target.when, target.share, target.after)
    assert read == expected


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "expected a metric's name, got nothing"),
        ("e", "expected <, <=, > or >= after 'e', got nothing"),
        ("e == 5 m", "got '='"),
        ("e => 5 m", "got '='"),
        ("5 < e", "expected a metric's name, got '5'"),
        ("e < 0,05 m", "expected a number such as 0.05 after 'e <', got '0,05'"),
        ("e < nan m", "got 'nan'"),
        ("e < 1e999 m", "got '1e999'"),
        ("e < 1_000 m", "got '1_000'"),
        ("e < 5 m for 95 of the time", "expected '%'"),
        ("e < 5 m for 195 % of the time", "up to 100"),
        ("e < 5 m for 0 % of the time", "above 0"),
        ("e < 5 m for 95 % of time", "expected 'the'"),
        ("e < 5 m soon", "expected when it holds after 'e < 5 m', got 'soon'"),
        ("e < 5 m at end", "expected 'the'"),
        ("e < 5 m always always", "expected the end of the target"),
        ("e < 5 m after -3 s", "seconds from 0 on"),
        ("e < 5 m after 3 min", "expected 's'"),
    ],
)
def test_what_does_not_is_refused_with_the_place_and_the_grammar(text, said):
    with pytest.raises(ParameterError) as refused:
        parse_target(text)
    assert said in str(refused.value)
    assert GRAMMAR in str(refused.value)


@pytest.mark.parametrize(
    ("text", "unit", "limit"),
    [
        ("e < 5 cm", "m", 0.05),
        ("e < 5 mm", "m", 0.005),
        ("e < 5 m", "cm", 500.0),
        ("e < 180 deg", "rad", math.pi),
        ("e < 12 °/s", "rad/s", math.radians(12)),
        ("e < 2 min", "s", 120.0),
        ("e < 95 %", "share", 0.95),
        ("e < 3 J", "J", 3.0),
        ("e < 3", "", 3.0),
    ],
)
def test_units_of_one_kind_are_turned_into_each_other(text, unit, limit):
    assert parse_target(text).limit_in(unit) == pytest.approx(limit, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "unit", "said"),
    [
        ("e < 5 s", "m", "got 5 s, but e is in m; write a value in m or cm or mm"),
        ("e < 5", "m", "got 5, but e is in m"),
        ("e < 5 m", "", "got 5 m, but e is a pure number"),
        ("e < 5 m", "J", "got 5 m, but e is in J; write a value in J"),
        ("e < 0.9", "share", "write a value in share or %"),
    ],
)
def test_a_length_is_never_held_against_a_time(text, unit, said):
    with pytest.raises(ParameterError) as refused:
        parse_target(text).limit_in(unit)
    assert said in str(refused.value)


SIGNS = ["<", "<=", ">", "=", "5", "0.05", "95", "-1", "nan", "%", "m", "s", "×"]
WORDS = ["e", "for", "of", "the", "time", "always", "on", "average", "at", "end", "after"]


@given(st.lists(st.sampled_from(SIGNS + WORDS), max_size=12), st.sampled_from(["", " "]))
def test_any_words_are_read_or_refused(words, between):
    text = between.join(words)
    with contextlib.suppress(ParameterError):
        target = parse_target(text)
        assert math.isfinite(target.value)
        assert parse_target(target.text) == target
