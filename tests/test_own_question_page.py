"""The page on one's own question does what it shows: its files, its commands, their answers."""

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import PosflockError

pytestmark = pytest.mark.slow  # five runs and reports
PAGE = Path(__file__).parents[1] / "docs/tutorials/own-question.md"
TEXT = PAGE.read_text(encoding="utf-8")
FILES = ("formation.py", "shape.py", "my_metrics.py")


def commands():
    """Return each command of the page with the lines that are shown below it."""
    for block in re.findall(r"^```console\n(.*?)^```", TEXT, re.M | re.S):
        for part in block.split("$ ")[1:]:
            line, *shown = part.splitlines()
            yield shlex.split(line), shown


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("own")
    blocks = re.findall(r"^```py\n(.*?)^```", TEXT, re.M | re.S)
    assert len(blocks) == len(FILES)
    for name, block in zip(FILES, blocks, strict=True):
        (place / name).write_text(block)
    return place


@pytest.fixture(scope="module")
def results(folder):
    """Run every command of the page once, in order, in the folder of its files."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        # Figures have tests of their own, and take longer than all the rest.
        patch.setattr("posflock_robotarium.report.curve_figures.draw", lambda *_: [])
        done = []
        for (program, *arguments), shown in commands():
            assert program == "posflock"
            result = CliRunner().invoke(app, arguments)
            done.append((arguments, shown, result))
        return done


def test_every_command_of_the_page_succeeds_and_says_what_is_shown(results):
    assert len(results) == 7
    for arguments, shown, result in results:
        assert result.exit_code == 0, (arguments, result.output, result.exception)
        said = [line for line in result.output.splitlines() if not line.startswith("   " * 3)]
        assert [line for line in shown if line not in said] == [], result.output


def test_the_report_of_the_page_is_about_the_formation(results, folder):
    page = (folder / "report" / "report.html").read_text(encoding="utf-8")
    assert "Did the flock" not in page
    assert "formation_error &lt; 0.06 m for 95 % of the time after 20 s?" in page
    assert (folder / "against" / "reference_errors.csv").is_file()


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("run.positions - PLACES", "run.positions - PLACES[:, :5]"),
        ("return np.sqrt(np.mean(away**2, axis=1))", "return away"),
    ],
)
def test_what_the_page_says_of_mistakes_is_said(results, folder, monkeypatch, written, told):
    monkeypatch.chdir(folder)
    text = (folder / "my_metrics.py").read_text()
    assert written in text
    (folder / "mistaken.py").write_text(text.replace(written, told))
    with pytest.raises(PosflockError) as raised:
        CliRunner().invoke(
            app,
            ["report", "run/poses.npy", "--metric", "mistaken.py:formation_error"],
            catch_exceptions=False,
        )
    assert f"posflock: {raised.value}".replace("mistaken", "my_metrics") in TEXT
