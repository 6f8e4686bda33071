"""Kinds and outcomes are enums whose members are printed, stored and read as their words."""

import json

import numpy as np
import pytest

from barrier_certificates.projection import Status
from posflock_robotarium.alignment.verdicts import Mark
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.submission.returned_files import FileState
from posflock_robotarium.sweep.parameter_distribution import ParameterSpread
from posflock_robotarium.verify.findings import Code
from rps_compat.distributions import DistributionKind
from rps_compat.logged_end import LoggedEnd
from rps_compat.porting import ChangeKind
from rps_compat.running.outcome import Ended
from rps_compat.running.plan import ClockPolicy, RunPlan
from rps_compat.running.policy_violations import PolicyKind, PolicyViolation, read_violation
from rps_compat.violations import FaultKind

ENUMS = [
    ChangeKind, ClockPolicy, Code, DistributionKind, Ended, FaultKind, FileState, LoggedEnd, Mark,
    Model, PolicyKind, ParameterSpread, Status,
]  # fmt: skip


@pytest.mark.parametrize("words", ENUMS, ids=lambda words: words.__name__)
def test_a_member_is_its_word_wherever_it_is_printed_or_stored(words):
    for member in words:
        word = member.value
        assert type(word) is str
        assert member == word
        assert {word: 1}[member] == {member: 1}[word] == 1
        assert str(member) == f"{member}" == "{}".format(member) == "%s" % member == word  # noqa: UP031, UP032
        assert f"{member:24}|" == f"{word:24}|"
        assert json.loads(json.dumps({"it": member, member: 1})) == {"it": word, word: 1}
        assert np.array([member]).astype("U64")[0] == word
        assert words(word) is member


def test_a_member_goes_into_a_field_of_bytes():
    row = np.zeros(1, dtype=[("status", "S16")])
    row["status"][0] = Status.OPTIMAL
    assert row["status"][0] == b"optimal"


def test_what_is_read_from_json_is_a_member_again():
    plan = RunPlan("s.py", ".", 2, clock=ClockPolicy.CHARGED, forbidden=(PolicyKind.FORK,))
    back = RunPlan.from_dict(json.loads(plan.text()))
    assert back.clock is ClockPolicy.CHARGED
    assert back.forbidden[0] is PolicyKind.FORK
    assert RunPlan.from_dict({"script": "s.py", "folder": ".", "generation": 2}).forbidden == ()
    violation = PolicyViolation(PolicyKind.NETWORK, "x", 3)
    told = {"kind": "network", "what": "x", "line": 3, "file": "", "time": 0.0}
    assert read_violation(told) == violation
    assert read_violation(told).kind is PolicyKind.NETWORK


def test_what_testbed_and_policy_find_fault_with_is_what_verify_tells():
    for kind in (*FaultKind, *PolicyKind):
        assert Code(kind.value).value == kind.value
