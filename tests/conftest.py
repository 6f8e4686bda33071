"""What every test gets: one seed for hypothesis, no figure left open, no API left installed."""

import sys
from collections.abc import Iterator

import pytest
from hypothesis import settings

settings.register_profile("project", deadline=None, derandomize=True, max_examples=60)
settings.load_profile("project")


@pytest.fixture(autouse=True)
def _close_figures() -> Iterator[None]:
    yield
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is not None:
        pyplot.close("all")


@pytest.fixture(autouse=True)
def _uninstall() -> Iterator[None]:
    yield
    compat = sys.modules.get("rps_compat")
    if compat is not None:
        compat.uninstall()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run the tests that share a costly fixture in one worker, or each worker would make it.

    `pytest -n 2 --dist loadgroup` obeys.
    """
    for item in items:
        assert isinstance(item, pytest.Function)
        definitions = item._fixtureinfo.name2fixturedefs.values()
        if any(fixture.scope == "module" for found in definitions for fixture in found):
            item.add_marker(pytest.mark.xdist_group(item.path.stem))
