"""Who is asked about a run, and when: every judgement by its code, from outcomes made by hand."""

from dataclasses import replace
from pathlib import Path

import pytest

from posflock_robotarium.verify.data_files import Readable
from posflock_robotarium.verify.findings import Code, Finding, Verdict
from posflock_robotarium.verify.judge import Runs, drive_time, judge
from posflock_robotarium.verify.trials import Ran
from rps_compat import testbed
from rps_compat.report import Fault, RunReport
from rps_compat.running.outcome import Ended, Failure, Gap, LoopTimes, Outcome
from rps_compat.running.policy_violations import PolicyKind, PolicyViolation
from rps_compat.violations import FaultKind

QUICK = LoopTimes(0.001, 0.002, 0.003, 0.0, 1.0)
SLOW = LoopTimes(0.05, 0.06, 0.07, 0.9, 1.0)
CRASH = Failure("ValueError", "ValueError", ("ValueError",), "no", 7, "main.py")


def report_of(robots=2, faults=(), outside=0, wheels=0):
    return RunReport(robots, 100, 3.3, 0, outside, wheels, 0, 20.0, tuple(faults))


def outcome(**changes):
    sound = Outcome(
        Path("main.py"),
        2,
        Ended.FINISHED,
        reports=(report_of(),),
        steps=100,
        time=3.3,
        clock=3.3,
        finishing_call=True,
        smallest_gap=Gap(0.4, 0.0, (0, 1)),
        initial_gap=Gap(0.4, 0.0, (0, 1)),
        loop=QUICK,
    )
    return replace(sound, **changes)


def ran(data=None, **changes):
    found = {} if data is None else {"log.npy": Readable(100, True, 10, data)}
    return Ran(outcome(**changes), Path(), found)


def judged(ideal=None, trials=(), known=(), drive=None, interrupted=None, killed=None, **options):
    """Return the codes found, with how bad each is, in their order; that of no data left out."""
    declared, counted = options.get("declared"), options.get("counted", False)
    runs = Runs(ideal or ran(), tuple(trials), drive, interrupted, killed)
    found = judge(runs, known, declared, counted)
    return [(f.code.value, f.verdict.name) for f in found if f.code is not Code.NOTHING_SAVED]


def seen(code):
    return Finding(Code(code), Verdict.FAIL, "seen in the source")


def fault(kind, at=1.0, worst=0.1):
    return Fault(FaultKind(kind), (0, 1), at, at, worst)


def test_a_sound_run_has_no_findings():
    assert judged() == []
    assert (
        judged(trials=[ran() for _ in range(3)], drive=outcome(), interrupted=ran(), killed=ran())
        == []
    )


@pytest.mark.parametrize(
    ("ideal", "expected"),
    [
        ({"ended": Ended.FAILED, "error": CRASH}, [("crash", "FAIL")]),
        ({"ended": Ended.OVER_TIME}, [("endless", "RISK")]),
        ({"policy_violations": (PolicyViolation(PolicyKind.FORK, "ls"),)}, [("fork", "FAIL")]),
        ({"reports": (report_of(faults=[fault("collision")]),)}, [("collision", "FAIL")]),
        ({"reports": (report_of(faults=[fault("boundary")], outside=3),)}, [("boundary", "RISK")]),
        (
            {"reports": (report_of(faults=[fault("actuator", worst=20.0)], wheels=3),)},
            [("actuator", "NOTE")],
        ),
        ({"initial_gap": Gap(0.14, 0.0, (0, 1))}, [("close-start", "RISK")]),
        ({"loop": SLOW}, [("slow-loop", "RISK")]),
        ({"clock": 1000.0}, [("duration", "FAIL")]),
        # A run that ran out of memory was slow because of that.
        (
            {"loop": SLOW, "ended": Ended.OUT_OF_MEMORY, "error": Failure("MemoryError")},
            [("memory", "FAIL")],
        ),
    ],
)
def test_each_fault_of_the_ideal_run_is_told(ideal, expected):
    assert judged(ran(**ideal)) == expected


def test_faults_are_told_in_the_order_in_which_a_reader_wants_them():
    everything = ran(
        data="a",
        ended=Ended.OVER_TIME,
        reports=(report_of(30, [fault(k, worst=20.0) for k in ("boundary", "actuator")], 3, 3),),
        policy_violations=(PolicyViolation(PolicyKind.FORK, "ls"),),
        initial_gap=Gap(0.14, 0.0, (0, 1)),
        loop=SLOW,
    )
    lost = ran(time=1.0)
    assert [code for code, _ in judged(everything, interrupted=lost, counted=True)] == [
        "fork", "too-many-robots", "boundary", "actuator", "close-start", "slow-loop", "duration",
        "data-lost",
    ]  # fmt: skip


def test_trials_tell_what_imperfections_bring_out():
    hit = [ran(reports=(report_of(faults=[fault("collision")]),)), *[ran() for _ in range(9)]]
    assert judged(trials=hit) == [("collision", "RISK")]
    out = [ran(reports=(report_of(faults=[fault("boundary")]),)) for _ in range(10)]
    assert judged(trials=out) == [("boundary", "FAIL")]
    failed = [ran(), ran(ended=Ended.FAILED, error=CRASH)]
    assert judged(trials=failed) == [("crash", "RISK")]
    # What only a trial did against the policy is told as well.
    networked = [ran(policy_violations=(PolicyViolation(PolicyKind.NETWORK, "x"),))]
    assert judged(trials=networked) == [("network", "RISK")]


def test_the_drive_and_the_interrupted_runs_are_asked():
    late = outcome(ended=Ended.FAILED, error=Failure("InitialConditionsError", message="robot 1"))
    assert judged(drive=late) == [("unreachable-start", "RISK")]
    whole, nothing, half = ran("a"), ran(), ran("b")
    assert judged(whole, interrupted=nothing) == [("data-lost", "RISK")]
    assert judged(whole, interrupted=half, killed=nothing) == [("data-lost", "NOTE")]
    assert judged(whole, interrupted=half, killed=half) == []


def test_a_declared_duration_is_what_counts():
    assert judged(ran(clock=300.0)) == []
    assert judged(ran(clock=300.0), declared=400.0) == []
    assert judged(ran(clock=300.0), declared=310.0) == [("duration", "RISK")]
    assert judged(ran(clock=300.0), declared=290.0) == [("duration", "FAIL")]
    assert judged(ran(clock=300.0, ended=Ended.OVER_TIME), declared=300.0, counted=True) == [
        ("duration", "FAIL")
    ]


def test_a_run_that_fits_but_for_its_drive_is_a_risk_and_a_step_is_none():
    """7273 steps of 33 ms are 240.009 s: what was declared as 240 s is not too short for that."""
    for seconds in (240.0, 240.009):
        (found,) = judge(Runs(ran("a", clock=seconds)), [], 240.0)
        assert found.verdict is Verdict.RISK
        assert "it fits the 240 s that are declared except for the drive" in found.message
    (found,) = judge(Runs(ran("a", clock=241.0)), [], 240.0)
    assert found.verdict is Verdict.FAIL


def test_a_drive_that_takes_long_in_the_simulator_takes_no_less_in_reality():
    slow = outcome(ended=Ended.STOPPED, time=120.0)
    assert judged(ran(clock=200.0), declared=310.0, drive=slow) == [("duration", "RISK")]
    assert drive_time(Runs(ran(), drive=slow)).least == 120.0
    assert drive_time(Runs(ran(), drive=outcome(ended=Ended.FAILED, time=600.0))).most < 120.0


def test_wheels_and_stalls_are_judged_by_the_worst_trial():
    faults = [fault("actuator", worst=20.0)]
    saturated = ran(reports=(report_of(faults=faults, wheels=690),), seed=3)
    assert judged(trials=[ran(), saturated]) == [("actuator", "RISK")]
    (found,) = judge(Runs(ran("a"), (ran(), saturated)), [])
    assert "in 690 steps in the trial with seed 3, 0 in the ideal run" in found.message
    stalled = ran(loop=replace(QUICK, longest=0.6, at=2.0))
    assert judged(trials=[ran(), stalled]) == [("watchdog", "RISK")]
    # One busy trial makes no slow loop; most of them do.
    assert judged(trials=[ran(loop=SLOW), ran(), ran()]) == []
    assert judged(trials=[ran(loop=SLOW), ran(loop=SLOW)]) == [("slow-loop", "RISK")]


def test_a_run_that_leaves_no_file_is_told_what_comes_back():
    (found,) = judge(Runs(ran()), [])
    assert (found.code, found.verdict) == (Code.NOTHING_SAVED, Verdict.NOTE)
    assert judge(Runs(ran("a")), []) == []
    assert Code.NOTHING_SAVED not in [f.code for f in judge(Runs(ran(ended=Ended.OVER_TIME)), [])]


def test_what_the_source_said_is_not_told_twice():
    many = ran(reports=(report_of(testbed.MAX_ROBOTS + 1),))
    assert judged(many) == [("too-many-robots", "FAIL")]
    assert judged(many, known=[seen("too-many-robots")]) == []
    assert judged(ran(reports=(report_of(testbed.MAX_ROBOTS),))) == []
    silent = ran(finishing_call=False)
    assert judged(silent) == [("no-finishing-call", "RISK")]
    assert judged(silent, known=[seen("no-finishing-call")]) == []
    forked = ran(policy_violations=(PolicyViolation(PolicyKind.FORK, "ls"),))
    assert judged(forked, known=[seen("fork")]) == []
    lost = {"interrupted": ran()}
    assert judged(ran("a"), known=[seen("save-at-end")], **lost) == []
    explained = replace(seen("generation"), line=7)
    crashed = ran(ended=Ended.FAILED, error=replace(CRASH, lines=((7, "main.py"),)))
    assert judged(crashed, known=[explained]) == []
    late = outcome(ended=Ended.FAILED, error=replace(CRASH, lines=((7, "main.py"),)))
    assert judged(drive=late, known=[explained]) == []
    sleepy = replace(seen("slow-sleep"), figure=0.05)
    assert judged(ran(loop=SLOW), known=[sleepy]) == []


def test_only_a_run_that_ended_by_itself_misses_its_finishing_call():
    for ended in Ended:
        found = [code for code, _ in judged(ran(ended=ended, finishing_call=False), counted=True)]
        assert ("no-finishing-call" in found) == (ended is Ended.FINISHED), ended


@pytest.mark.parametrize(("generation", "call"), [(1, "call_at_scripts_end()"), (2, "debug()")])
def test_the_finishing_call_is_that_of_the_generation(generation, call):
    (found,) = judge(Runs(ran("a", generation=generation, finishing_call=False)), [])
    assert f"without having called {call}" in found.message
    assert found.advice == f"end the script with r.{call}"


def test_a_script_that_never_steps_is_told_only_that():
    idle = {"steps": 0, "loop": SLOW, "finishing_call": False}
    assert judged(ran(**idle)) == [("no-step", "FAIL")]
    assert judged(ran(**idle, reports=())) == [("no-step", "FAIL")]
    assert judged(ran(**(idle | {"steps": None}))) == [("no-step", "FAIL")]
    # Its end is told already: by the error, or by the source.
    assert judged(ran(**idle, ended=Ended.FAILED, error=CRASH)) == [("crash", "FAIL")]
    assert judged(ran(**idle), known=[seen("no-finishing-call")]) == []
    (found,) = judge(Runs(ran(**idle)), [])
    assert found.message == "ends without a single step() of a Robotarium"
    assert found.advice == "call get_poses(), set_velocities() and step() in a loop"


def test_whether_the_loop_counts_its_steps_decides_between_long_and_endless():
    endless = ran(ended=Ended.OVER_TIME, clock=900.0, time=900.0)
    assert judged(endless) == [("endless", "RISK")]
    (found,) = judge(Runs(endless), [])  # nobody says that it counts
    assert found.code == "endless"
    assert judged(endless, counted=True) == [("duration", "FAIL")]


def test_a_run_without_a_report_is_judged_by_the_rest():
    assert judged(ran(reports=())) == []
    assert judged(ran(reports=(), loop=SLOW)) == [("slow-loop", "RISK")]
