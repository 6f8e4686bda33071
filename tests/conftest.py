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
