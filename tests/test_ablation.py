"""An ablation runs each imperfection as often as it was asked, and counts each in its own row."""

from collections import Counter
from pathlib import Path

import pytest

from posflock_robotarium.alignment.intervals import wilson_interval
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.verify import ablate
from posflock_robotarium.verify.ablation import EFFECT_TRIALS
from posflock_robotarium.verify.trials import Ran, TrialRoom
from rps_compat.distributions import ProfileError
from rps_compat.profiles import chosen_profile
from rps_compat.report import Fault, RunReport
from rps_compat.running.outcome import Ended, Gap, Outcome
from rps_compat.violations import FaultKind

SCRIPT = """\
import numpy as np
from rps.robotarium import Robotarium
r = Robotarium(number_of_robots=2, show_figure=False)
r.get_poses()
r.step()
r.debug()
"""


def outcome(plan, kinds=(), ended=Ended.FINISHED, gap=0.3):
    faults = tuple(Fault(FaultKind(kind), (0,), 0.0, 0.1, 0.2) for kind in kinds)
    report = RunReport(2, 10, 0.33, 0, 0, 0, 0, 0.0, faults)
    nearest = None if gap is None else Gap(gap, 0.0, (0, 1))
    script = Path(plan.script)
    return Outcome(script, 2, ended, reports=(report,), name=plan.name, smallest_gap=nearest)


@pytest.fixture
def ablated(tmp_path, monkeypatch):
    """Return a function that ablates a script whose trials end as `ends(plan)` says."""
    script = tmp_path / "main.py"
    script.write_text(SCRIPT)
    planned = []

    def with_ends(ends=outcome, **options):
        def run(self, plans, tell=None):
            planned.extend(plans)
            found = [ends(plan) for plan in plans]
            for one in reversed(found):  # they end in any order
                if tell is not None:
                    tell(one)
            return [Ran(one, Path(plan.folder), {}) for one, plan in zip(found, plans, strict=True)]

        planned.clear()
        monkeypatch.setattr(TrialRoom, "run", run)
        return ablate(script, **options), list(planned)

    return with_ends


@pytest.mark.parametrize("trials", [1, 3, 7])
def test_each_imperfection_has_the_trials_that_were_asked_for_each_with_its_seed(ablated, trials):
    rows, plans = ablated(effects=["dead_time", "lag"], trials=trials, seed=20)
    assert [row.effect for row in rows] == ["dead_time", "lag", "all"]
    assert {row.trials for row in rows} == {trials}
    assert len(plans) == 3 * trials
    for effect in ("dead_time", "lag", "all"):
        own = [plan for plan in plans if plan.name.startswith(f"{effect}-")]
        assert [plan.seed for plan in own] == list(range(20, 20 + trials))
        assert {plan.initial for plan in own} == {"arrive"}
        under = set(chosen_profile(None, 2).effects) if effect == "all" else {effect}
        assert all(plan.profile.keys() - {"name", "about"} == under for plan in own)


def test_where_nobody_says_every_imperfection_of_the_profile_runs_five_times(ablated):
    rows, plans = ablated()
    assert [row.effect for row in rows] == [*chosen_profile(None, 2).effects, "all"]
    assert {row.trials for row in rows} == {EFFECT_TRIALS} == {5}
    assert {plan.seed for plan in plans} == set(range(5))


def test_each_row_counts_its_own_trials(ablated):
    ends = {
        "dead_time-0": {"kinds": ("collision", "boundary", "collision"), "gap": 0.1},
        "dead_time-1": {"kinds": ("boundary",), "ended": Ended.OVER_TIME, "gap": 0.2},
        "dead_time-2": {"ended": Ended.FAILED, "gap": None},
        "lag-0": {"kinds": ("actuator",), "gap": None},
        "lag-1": {"gap": None},
        "lag-2": {"gap": None},
        "all-1": {"kinds": ("collision",), "ended": Ended.HUNG},
        "all-2": {"kinds": ("collision",), "ended": Ended.IDLE},
    }
    rows, _ = ablated(
        lambda plan: outcome(plan, **ends.get(plan.name, {})),
        effects=["dead_time", "lag"],
        trials=3,
    )
    numbers = [(r.effect, r.trials, r.collisions, r.outside, r.failed) for r in rows]
    assert numbers == [("dead_time", 3, 1, 2, 1), ("lag", 3, 0, 0, 0), ("all", 3, 2, 0, 2)]
    assert rows[0].gap == 0.1
    assert rows[1].gap is None
    assert rows[2].gap == 0.3
    assert rows[2].interval == wilson_interval(2, 3)


def test_every_end_is_told_with_how_many_there_are(ablated):
    told = []
    ablated(effects=["lag"], trials=2, tell=lambda *said: told.append(said))
    assert Counter(name for name, _, _ in told) == Counter(["lag-0", "lag-1", "all-0", "all-1"])
    assert [(done, of) for _, done, of in told] == [(1, 4), (2, 4), (3, 4), (4, 4)]


def test_an_ablation_of_what_is_no_python_or_of_an_unknown_effect_is_refused(ablated, tmp_path):
    with pytest.raises(ProfileError, match="no effect is called 'sunshine'"):
        ablated(effects=["sunshine"])
    (tmp_path / "main.py").write_text("x = (")
    with pytest.raises(ParameterError, match="is not valid Python; `posflock verify` says where"):
        ablated()
