"""The paper recomputed, on a few seeds: claims judged by thresholds, tables, figures, command."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from posflock_robotarium.alignment.point_agents import measure, summarise
from posflock_robotarium.cli import app
from posflock_robotarium.figures.style import new_figure, save
from posflock_robotarium.flocking.errors import OutputError, ParameterError
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.freespace.simulation import FreeSpace, simulate
from posflock_robotarium.paper.claim import Claim, Result, Sense
from posflock_robotarium.paper.claims import CLAIMS, judge_all
from posflock_robotarium.paper.gathering import gather
from posflock_robotarium.paper.reproduction import reproduce

#: A quarter of the agents for a quarter of the time, at the paper's density.
REHEARSAL = FreeSpace(agents=12, side=12.25, duration=24.0, record_interval=0.5)


def laid_out(figure, folder, name):
    """Lay a figure out as `save` does, in a fraction of the time: no fonts are embedded."""
    figure.draw_without_rendering()
    return save(new_figure(1.0, 1.0), folder, name)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Reproduce the paper in small, on two seeds."""
    folder = tmp_path_factory.mktemp("rehearsal")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("posflock_robotarium.paper.paper_figures.save", laid_out)
        return reproduce(folder, seeds=2, paper=REHEARSAL, driving=21.0, workers=1)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Reproduce the paper on two seeds."""
    return reproduce(tmp_path_factory.mktemp("paper"), seeds=2, workers=2)


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
    page = (folder / "claims.md").read_text()
    assert all(f"## {claim.id}\n" in page for claim in CLAIMS)


@pytest.mark.slow
def test_the_paper_itself_is_judged_as_it_was_measured(whole):
    verdicts = {judgement.claim.id: judgement.verdict for judgement in whole.judgements}
    for id_ in ("variance-increases", "no-collisions", "imprint-fades", "smaller-radius"):
        assert verdicts[id_] is Result.DOES_NOT_HOLD, id_
    for id_ in ("persistent-direction", "more-compact", "constant-radius", "robots-safe"):
        assert verdicts[id_] is Result.HOLDS, id_


@pytest.mark.parametrize("id_", ["no-collisions", "imprint-fades", "variance-increases"])
def test_sentences_that_do_not_hold_are_said_not_to(found, id_):
    (judgement,) = [j for j in found.judgements if j.claim.id == id_]
    assert judgement.verdict is Result.DOES_NOT_HOLD


@pytest.mark.parametrize(
    ("sense", "value", "verdict"),
    [
        ("at least", 2.0, "holds"),
        ("at least", 1.5, "holds weakly"),
        ("at least", 0.9, "does not hold"),
        ("at least", math.nan, "does not hold"),
        ("at most", -2.0, "holds"),
        ("at most", -1.0, "holds weakly"),
        ("at most", 0.0, "does not hold"),
    ],
)
def test_a_verdict_follows_from_the_number(sense, value, verdict):
    sign = 1.0 if sense == "at least" else -1.0
    claim = Claim("x", "", "", lambda _: value, Sense(sense), 2.0 * sign, 1.0 * sign)
    judgement = claim.judge(None)
    assert judgement.verdict is Result(verdict)
    json.dumps(judgement.as_dict(), allow_nan=False)


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


def test_evidence_does_not_depend_on_workers(found):
    of_one = found.evidence.measures[Model.POSITION]
    alone = measure(simulate(replace(REHEARSAL, model=Model.POSITION), 1), 7.5)
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
    weak = sum(j.verdict is Result.DOES_NOT_HOLD for j in found.judgements)
    assert f"{weak} does not hold" in lines[len(found.judgements)]


def test_the_command_explains_itself():
    result = CliRunner().invoke(app, ["reproduce", "--help"])
    assert result.exit_code == 0
    assert "claims.json" in result.output
