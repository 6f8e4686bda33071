"""The forms of logs stand in a registry: a new one is one entry, and the surest sign wins."""

import json
from pathlib import Path

import numpy as np
import pytest
from rolling_robots import POSES, log_of, rolling
from typer.testing import CliRunner

from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import LogError, ParameterError
from posflock_robotarium.logs.readers import (
    Form,
    Found,
    Sign,
    form_of,
    known_forms,
    register,
    registered,
)
from posflock_robotarium.report import read


def track(told_by=Sign.SIGNATURE, **changes):
    """A form as a user might add it: poses of one robot under a line of its own."""

    def read_track(file, options):
        rows = np.loadtxt(file, skiprows=1)
        return Found(rows[:, 0], rows[:, 1:, np.newaxis], ("a track of one robot",))

    parts = {
        "name": "track",
        "label": "`.track`",
        "summary": "one robot: t, x, y, theta",
        "recognises": lambda file, start: start.startswith(b"TRACK"),
        "read": read_track,
        "endings": (".track",),
    }
    return Form(told_by=told_by, **parts | changes)


def test_a_new_form_is_one_entry_and_every_command_reads_it(tmp_path):
    t, poses = rolling(60, 1)
    file = tmp_path / "run.track"
    np.savetxt(file, np.column_stack([t, poses[:, :, 0]]), header="TRACK", comments="")
    words = ["report", str(file), "-o", str(tmp_path / "out"), "--json", "--radius", "1"]
    words.append("--no-figures")
    # Without the entry, its first line is a header of one column.
    assert CliRunner().invoke(app, words).exception is not None
    with registered(track()):
        done = CliRunner().invoke(app, words)
        assert done.exit_code == 0, done.output
        assert "a track of one robot" in json.loads(done.output)["how_it_was_read"]
        np.testing.assert_allclose(read(file).poses, poses)
        (tmp_path / "damaged.track").write_bytes(file.read_bytes()[1:])
        with pytest.raises(LogError, match=r"not a \.track file, or its beginning is damaged"):
            read(tmp_path / "damaged.track")
    assert "track" not in [form.name for form in known_forms()]


def test_the_surest_sign_wins_whoever_registered_first(tmp_path):
    np.save(tmp_path / "run.npy", POSES)
    anything = {"name": "mine", "recognises": lambda file, start: True}
    for told_by, wins in (
        (Sign.CONTENT, "mine"),
        (Sign.SIGNATURE, "npy"),
        (Sign.ENDING, "npy"),
        (Sign.NOTHING, "npy"),
    ):
        with registered(track(told_by, **anything)):
            assert form_of(tmp_path / "run.npy").name == wins
    log_of(tmp_path / "log", 40).close()
    assert form_of(tmp_path / "log.npy").name == "pose log"


def test_a_name_is_registered_once():
    with registered(track()), pytest.raises(ParameterError, match="registered already"):
        register(track())


def test_the_documentation_and_the_help_list_every_form():
    page = (Path(__file__).parents[1] / "docs/reference/log-forms.md").read_text(encoding="utf-8")
    help_text = CliRunner().invoke(app, ["report", "--help"], env={"COLUMNS": "200"}).output
    for form in known_forms():
        assert f"| {form.label} | {form.summary} |" in page
        if form.name not in ("pose log", "pickle"):  # "ours", and what is refused
            assert form.label.replace("`", "") in help_text
