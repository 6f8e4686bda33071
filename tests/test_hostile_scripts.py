"""Hostile and careless scripts: the verdict is true and the machine clean, in both containments."""

import os

import pytest
from hostile_cases import NATIVE, SCRIPTS, Machine, becomes, containments, table, wrong

from posflock_robotarium.verify.trials import ForkServer
from rps_compat.containment.namespaces import VARIABLE

#: Those that `make test` tries: one of each kind of deed.
QUICK = {
    "closes_everything",
    "connects",
    "database_elsewhere",
    "ends_the_verifier",
    "fills_the_disk",
    "forges_a_report",
    "forks",
    "loads_a_table_by_a_hidden_url",
    "one_large_file",
    "prints_for_ever",
    "removes_by_descriptor",
    "sends_messages",
    "speaks_for_itself",
    "starts_a_program",
    "writes_through_a_link",
}
QUICK_NATIVE = {"makes_a_pipe", "attaches_a_database", "shares_memory"}


def quick_first(scripts, quick):
    return [
        pytest.param(path, id=path.stem, marks=() if path.stem in quick else pytest.mark.slow)
        for path in scripts
    ]


@pytest.fixture(scope="module", params=["namespaces", "hook"])
def half(request):
    """Give the half of the containments, a machine, and the process that runs trials there."""
    how = containments()[request.param]
    if how is None:
        pytest.skip("the kernel refuses namespaces: this half of the containment is not tried here")
    before = os.environ.get(VARIABLE)
    os.environ[VARIABLE] = how.value
    try:
        with Machine() as machine:
            with ForkServer() as server:
                assert server.containment is how
                yield request.param, server, machine
            assert machine.left_running() == []
    finally:
        del os.environ[VARIABLE]
        if before is not None:
            os.environ[VARIABLE] = before


@pytest.mark.parametrize("script", quick_first(SCRIPTS, QUICK))
def test_the_deed_is_named_and_nothing_comes_of_it(half, script):
    _, server, machine = half
    assert wrong(script, server, machine) == []


@pytest.mark.parametrize("script", quick_first(NATIVE, QUICK_NATIVE))
def test_what_native_code_can_do_is_what_security_says(half, script):
    name, server, machine = half
    assert becomes(script, server, machine) == table()[script.stem][name == "hook"]


def test_there_are_forty_and_security_tells_of_all_that_are_native():
    assert len(SCRIPTS) >= 40
    assert {path.stem for path in (*SCRIPTS, *NATIVE)} >= QUICK | QUICK_NATIVE
    assert set(table()) == {path.stem for path in NATIVE}
