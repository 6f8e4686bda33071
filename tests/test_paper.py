"""The paper recomputed, on a few seeds: claims judged by thresholds, tables, figures, command."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from posflock_robotarium.alignment.analysis import analyse
from posflock_robotarium.alignment.point_agents import measure, summarise
from posflock_robotarium.cli import app
from posflock_robotarium.figures.style import new_figure, save
from posflock_robotarium.flocking.errors import OutputError, ParameterError
from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.freespace import simulation as freespace
from posflock_robotarium.freespace.simulation import FreeSpace
from posflock_robotarium.paper.claim import Claim, Result, Sense
from posflock_robotarium.paper.claims import CLAIMS, judge_all
from posflock_robotarium.paper.evidence import Varied
from posflock_robotarium.paper.gathering import gather
from posflock_robotarium.paper.measured import Measured, exact, median_of, share_of
from posflock_robotarium.paper.measurements import robots_safe
from posflock_robotarium.paper.paper_figures import parameters
from posflock_robotarium.paper.reproduction import reproduce
from posflock_robotarium.paper.robots import WhiteNoise, drive
from posflock_robotarium.simulation.flock_trial import simulate

#: A quarter of the agents for a fifth of the time, at the paper's density.
REHEARSAL = FreeSpace(agents=12, side=12.25, duration=21.0, record_interval=0.5)


def laid_out(figure, folder, name):
    """Lay a figure out as `save` does, in a fraction of the time: no fonts are embedded."""
    figure.draw_without_rendering()
    return save(new_figure(1.0, 1.0), folder, name)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Reproduce the paper in small, on three seeds: fewer have no interval."""
    folder = tmp_path_factory.mktemp("rehearsal")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("posflock_robotarium.paper.paper_figures.save", laid_out)
        return reproduce(folder, seeds=3, paper=REHEARSAL, driving=20.5, workers=1)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Reproduce the paper on three seeds."""
    return reproduce(tmp_path_factory.mktemp("paper"), seeds=3, workers=2)


def test_claims_are_recomputed_and_written(found):
    folder = next(path.parent for path in found.paths if path.name == "claims.json")
    written = json.loads((folder / "claims.json").read_text())
    assert len(written) == len(CLAIMS) >= 15
    again = judge_all(found.evidence)
    for entry, judgement in zip(written, again, strict=True):
        assert set(entry) >= {"id", "claim", "test", "value", "verdict", "reason"}
        assert entry["id"] == judgement.claim.id
        assert entry["verdict"] == judgement.verdict.value
        assert entry["value"] == judgement.value
        assert entry["runs"] == judgement.measured.runs
        assert entry["interval"] == list(judgement.measured.interval)
    page = (folder / "claims.md").read_text()
    assert all(f"## {claim.id}\n" in page for claim in CLAIMS)


@pytest.mark.slow
def test_the_paper_itself_is_judged_as_it_was_measured(whole):
    verdicts = {judgement.claim.id: judgement.verdict for judgement in whole.judgements}
    for id_ in ("variance-increases", "no-collisions", "imprint-fades", "smaller-radius"):
        assert verdicts[id_] is Result.DOES_NOT_HOLD, id_
    for id_ in ("persistent-alignment", "persistent-direction", "constant-radius", "robots-align"):
        assert verdicts[id_] is Result.HOLDS, id_
    # Of three seeds not even three show that a share is 95 in 100.
    assert verdicts["robots-safe"] is Result.NOT_SETTLED


@pytest.mark.parametrize("id_", ["no-collisions", "imprint-fades", "variance-increases"])
def test_sentences_that_do_not_hold_are_said_not_to(found, id_):
    (judgement,) = [j for j in found.judgements if j.claim.id == id_]
    assert judgement.verdict is Result.DOES_NOT_HOLD


@pytest.mark.parametrize("sense", list(Sense))
@pytest.mark.parametrize(
    ("low", "high", "verdict"),
    [
        (2.0, 2.5, "holds"),
        (1.9, 2.5, "holds weakly"),
        (1.0, 1.9, "holds weakly"),
        (0.9, 2.5, "not settled"),
        (0.9, 1.0, "not settled"),
        (0.5, 0.9, "does not hold"),
        (-math.inf, 0.9, "does not hold"),
    ],
)
def test_a_verdict_follows_from_the_whole_interval(sense, low, high, verdict):
    """Mirrored about zero, it is the same claim in the other sense."""
    sign = 1.0 if sense is Sense.AT_LEAST else -1.0
    measured = Measured(sign * 1.5, tuple(sorted((sign * low, sign * high))), 100)
    judgement = Claim("x", "", "", lambda _: measured, sense, 2.0 * sign, 1.0 * sign).judge(None)
    assert judgement.verdict is Result(verdict)
    assert "do not settle" in judgement.reason or (low, high) not in ((1.9, 2.5), (0.9, 2.5))
    assert ("do not settle" in judgement.reason) == (low < 2.0 <= high or low < 1.0 <= high)
    json.dumps(judgement.as_dict(), allow_nan=False)


@pytest.mark.parametrize(
    ("value", "verdict"),
    [(2.0, "holds"), (1.5, "holds weakly"), (0.9, "does not hold"), (math.nan, "does not hold")],
)
def test_a_number_that_no_seed_changes_is_always_settled(value, verdict):
    judgement = Claim("x", "", "", lambda _: exact(value), Sense.AT_LEAST, 2.0, 1.0).judge(None)
    assert judgement.verdict is Result(verdict)
    assert "interval" not in judgement.reason
    json.dumps(judgement.as_dict(), allow_nan=False)


@pytest.mark.parametrize(
    "measured",
    [
        median_of(np.array([3.0, 3.0])),
        median_of(np.array([3.0, math.nan, 3.0])),
        share_of(np.ones(2) > 0),
    ],
    ids=["few seeds", "an unknown one", "few yes or no"],
)
def test_without_an_interval_nothing_is_settled(measured):
    judgement = Claim("x", "", "", lambda _: measured, Sense.AT_LEAST, 0.5, 0.1).judge(None)
    assert judgement.verdict is Result.NOT_SETTLED
    assert judgement.as_dict()["interval"] is None


@settings(max_examples=50)
@given(st.integers(3, 200), st.data(), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_two_sets_of_seeds_whose_intervals_meet_are_not_told_opposite_things(n, data, one, other):
    """A claim flips between "holds" and "does not hold" only where intervals are apart."""
    shares = [share_of(np.arange(n) < data.draw(st.integers(0, n))) for _ in range(2)]
    weakly, holds = sorted((one, other))
    verdicts = {
        Claim("x", "", "", lambda _, m=m: m, Sense.AT_LEAST, holds, weakly).judge(None).verdict
        for m in shares
    }
    if verdicts == {Result.HOLDS, Result.DOES_NOT_HOLD}:
        (low, high), (low_too, high_too) = (m.interval for m in shares)
        assert high < low_too or high_too < low


def test_shares_and_medians_tell_their_intervals():
    share = share_of(np.arange(100) < 96)
    assert (share.value, share.runs) == (0.96, 100)
    assert share.text == "0.96 [0.902, 0.984]"
    median = median_of(np.array([1.0, 2.0, 3.0, 4.0, math.inf]))
    assert median.value == 3.0
    assert median.interval == (1.0, math.inf)
    assert exact(0.25).text == "0.25"


def test_claims_are_judged_over_every_seed(found):
    """Variations that only figures show run fewer; no claim is judged by such a one."""
    for judgement in found.judgements:
        assert judgement.measured.runs in (None, len(found.evidence.seeds)), judgement.claim.id
    exact_ones = {j.claim.id for j in found.judgements if j.measured.runs is None}
    assert exact_ones == {"no-collisions", "rest-distance"}
    runs = {len(measures.gamma) for _, measures in found.evidence.variations}
    assert runs == {2, 3}


def test_what_is_said_of_all_robots_is_counted_by_seed(found):
    """A seed with one collision, ideal or noisy, is one seed that is not safe."""
    evidence = found.evidence
    assert robots_safe(evidence).value == 1.0
    noisy = evidence.imperfect_robots
    hurt = replace(noisy.summaries[1], collisions=7, steps_outside=2)
    summaries = (noisy.summaries[0], hurt, noisy.summaries[2])
    hit = replace(evidence, imperfect_robots=replace(noisy, summaries=summaries))
    assert robots_safe(hit).value == pytest.approx(2.0 / 3.0)


def test_a_team_among_many_drives_as_it_would_alone():
    together = drive((5, 1), imperfect=True, duration=1.0)
    start = random_poses(9, np.random.default_rng(1), side=1.0, spacing=0.30)
    alone = simulate(Flock(), start, 1.0, realism=WhiteNoise(), seed=1)
    gamma = analyse(alone.truth()).curves["gamma_motion"]
    np.testing.assert_allclose(together.gamma_motion[1], gamma, rtol=0, atol=1e-9)
    assert not np.allclose(together.gamma_motion[0], gamma, rtol=0, atol=1e-6)


def test_thresholds_are_in_order_and_ids_are_unique():
    for claim in CLAIMS:
        sign = 1.0 if claim.sense is Sense.AT_LEAST else -1.0
        assert sign * claim.weakly <= sign * claim.holds, claim.id
    assert len({claim.id for claim in CLAIMS}) == len(CLAIMS)


def test_a_verdict_changes_when_the_evidence_does(found):
    """The numbers decide: with the models exchanged the ranking claims fall."""
    evidence = found.evidence
    exchanged = dict(evidence.measures)
    exchanged[Model.POSITION], exchanged[Model.VELOCITY] = (
        exchanged[Model.VELOCITY],
        exchanged[Model.POSITION],
    )
    verdicts = {j.claim.id: j.verdict for j in judge_all(replace(evidence, measures=exchanged))}
    assert verdicts["more-compact"] is verdicts["persistent-direction"] is Result.DOES_NOT_HOLD
    assert Result.DOES_NOT_HOLD not in (
        j.verdict
        for j in found.judgements
        if j.claim.id in ("more-compact", "persistent-direction")
    )


@pytest.mark.slow
def test_every_figure_of_the_paper_is_drawn(whole):
    figures = [path for path in whole.paths if path.suffix in (".pdf", ".png")]
    assert len(figures) >= 24
    for path in figures:
        assert path.stat().st_size > 8000, path


def test_every_figure_is_written_twice_and_tables_hold_every_variation(found):
    names = {path.name for path in found.paths}
    figures = {path.stem for path in found.paths if path.suffix == ".pdf"}
    assert {f"{name}.png" for name in figures} <= names
    assert {"gain", "trajectories_single", "history_seeds", "rigidity_seeds"} <= figures
    folder = next(path.parent for path in found.paths if path.name == "tables.md")
    rows = (folder / "table_variations.csv").read_text().splitlines()
    assert len(rows) == 1 + len(found.evidence.variations)


def test_a_curve_is_drawn_over_the_same_seeds_at_every_value(found):
    """What is judged at one value has more; the curve would bend there."""
    drawn = parameters(found.evidence).axes[0].containers
    for container, model in zip(drawn, Model, strict=True):
        _, numbers = found.evidence.study(Varied.TIME_STEP, model)
        expected = [np.median(each["gamma_settled"][:2]) for each in numbers]
        np.testing.assert_allclose(container.lines[0].get_ydata(), expected)


def test_evidence_does_not_depend_on_workers(found):
    of_one = found.evidence.measures[Model.POSITION]
    alone = measure(freespace.simulate(replace(REHEARSAL, model=Model.POSITION), 1), 7.5)
    for name, value in summarise(alone).items():
        np.testing.assert_array_equal(summarise(of_one)[name][1], value, err_msg=name)


def test_one_seed_has_no_spread():
    with pytest.raises(ParameterError, match="at least 2"):
        gather(1)


def test_a_folder_that_cannot_be_written_is_refused_before_computing(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(OutputError, match="file"):
        reproduce(blocked / "below", seeds=2)


def test_the_command_prints_every_claim_with_its_verdict(found, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "posflock_robotarium.paper.reproduction.reproduce", lambda *args, **kwargs: found
    )
    result = CliRunner().invoke(app, ["reproduce", "-o", str(tmp_path)])
    lines = result.output.splitlines()
    for judgement, line in zip(found.judgements, lines, strict=False):
        words = judgement.verdict.value.split()
        assert line.split()[: len(words) + 1] == [*words, judgement.claim.id]
        assert line.endswith(judgement.measured.text)
    weak = sum(j.verdict is Result.DOES_NOT_HOLD for j in found.judgements)
    assert f"{weak} does not hold" in lines[len(found.judgements)]


def test_the_command_explains_itself():
    result = CliRunner().invoke(app, ["reproduce", "--help"])
    assert result.exit_code == 0
    assert "claims.json" in result.output
