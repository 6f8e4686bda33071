"""Help comes at once, for every command, and shows how it is used."""

import subprocess
import sys

import pytest
import typer
from typer.testing import CliRunner

from posflock_robotarium.cli import app

COMMANDS = sorted(typer.main.get_command(app).commands)

#: Libraries that take longer to import than a person waits for help.
HEAVY = {"scipy", "matplotlib", "cvxpy", "osqp", "h5py", "distributed"}


def test_no_command_imports_what_only_its_work_needs():
    code = "import sys, posflock_robotarium.cli; print(*sys.modules)"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not HEAVY & set(ran.stdout.split())


@pytest.mark.parametrize("command", COMMANDS)
def test_help_shows_examples_of_the_command(command):
    told = CliRunner().invoke(app, [command, "--help"])
    assert told.exit_code == 0
    assert "Examples" in told.output
    assert f"posflock {command}" in told.output
