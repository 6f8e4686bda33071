"""What every test gets: one seed for hypothesis, no figure left open, no API left installed.

And what tests share that is slow to start: the process that runs trials.
"""

import sys
from collections.abc import Iterator
from types import SimpleNamespace
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

if TYPE_CHECKING:
    from posflock_robotarium.verify.trials import ForkServer

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


@pytest.fixture(scope="session")
def fork_server() -> "Iterator[ForkServer]":
    """Share the process that runs trials: it takes as long to start as many a script to run."""
    from posflock_robotarium.verify.trials import ForkServer

    with ForkServer() as shared:
        yield shared


@pytest.fixture
def shared_trials(fork_server: "ForkServer", monkeypatch: pytest.MonkeyPatch) -> None:
    """Let commands run their trials in the shared process instead of one each."""
    kept = SimpleNamespace(ask=fork_server.ask, folder=fork_server.folder, close=lambda: None)
    monkeypatch.setattr("posflock_robotarium.verify.trials.ForkServer", lambda: kept)
