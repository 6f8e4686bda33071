"""What a reader sees of every metric: words, units, plots, rows and columns, in their order."""

import json
from pathlib import Path

from posflock_robotarium.alignment.catalogue import metrics, scalars

#: One line an entry, as `told` has them; whoever changes an entry changes its line too.
GOLDEN = Path(__file__).parent / "golden" / "metric_catalogue.json"


def shown(entry, *places):
    """Return what an entry says of itself, and where it is shown."""
    said = {name: getattr(entry, name) for name in ("label", "unit", "definition")}
    return said | {name: value for name in places if (value := getattr(entry, name))}


def told():
    """Return all of the catalogue that is no function."""
    places = ("of_interest", "figure", "legend", "beside_replay")
    curves = {}
    for key, metric in metrics().items():
        assert metric.key == key
        panel = {"panel": metric.panel.key} if metric.panel else {}
        numbers = {"numbers": [number.key for number in metric.numbers]}
        curves[key] = shown(metric, *places) | panel | numbers
    assert all(scalar.key == key for key, scalar in scalars().items())
    numbers = {key: shown(scalar, "group", "latex", "column") for key, scalar in scalars().items()}
    return {"curves": curves, "numbers": numbers}


def test_the_catalogue_says_what_was_last_agreed_on():
    expected, found = json.loads(GOLDEN.read_text("utf-8")), told()
    assert found == expected
    for kind in found:
        assert list(found[kind]) == list(expected[kind])  # the order of tables and figures
