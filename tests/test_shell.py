"""What a shell may expect: completion, closed pipes, any encoding, help at any width."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from posflock_robotarium.cli import app
from posflock_robotarium.commands.argument_order import may_read_arguments

GROUP = typer.main.get_command(app)
POSFLOCK = [sys.executable, "-m", "posflock_robotarium"]
TURNING = """
import numpy as np
from rps.robotarium import Robotarium
r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for k in range(9):
    r.get_poses()
    r.set_velocities([0], np.array([[0.1], [0.5]]))
    r.step()
print("γ = 1°, Müller")
r.debug()
"""


@pytest.fixture
def script(tmp_path):
    path = tmp_path / "turning.py"
    path.write_text(TURNING, encoding="utf-8")
    return path


def ran(*words, env=None, cwd=None):
    return subprocess.run(
        [*POSFLOCK, *map(str, words)], env={**os.environ, **(env or {})}, cwd=cwd,
        capture_output=True, check=False,
    )  # fmt: skip


# --- Help ---------------------------------------------------------------------------------------


def helped(command, width):
    words = [command, "--help"] if command else ["--help"]
    return CliRunner().invoke(app, words, terminal_width=width).output


@pytest.mark.parametrize("command", ["", *GROUP.commands])
@pytest.mark.parametrize("width", [40, 60])
def test_help_is_whole_at_any_width(command, width):
    told = helped(command, width)
    assert not re.search(r"<\w+>|\[/?bold\]", told)
    squeezed = "".join(told.split())
    for parameter in (GROUP.commands[command] if command else GROUP).params:
        assert "".join((parameter.help or "").split()) in squeezed
    if width == 60:
        assert max(map(len, told.splitlines())) <= width


def test_an_example_that_is_too_long_goes_on_as_a_shell_takes_it():
    told = helped("calibrate", 58)
    assert "--dt 0.0352 \\\n        -o lab.toml" in told
    assert "[t= 50.3s] at gate" in " ".join(told.split())


def test_options_have_one_name_and_one_meaning():
    names = {}
    for command in GROUP.commands.values():
        for parameter in command.params:
            for short in (name for name in parameter.opts if len(name) == 2):
                long = next(name for name in parameter.opts if name.startswith("--"))
                assert names.setdefault(short, long) == long
    used = {name for command in GROUP.commands.values() for p in command.params for name in p.opts}
    assert not {"--workers", "--first-seed", "--output", "--processes"} & used


@pytest.mark.parametrize("option", ["-V", "--version"])
def test_the_version_is_asked_for_in_two_ways(option):
    assert CliRunner().invoke(app, [option]).output.startswith("posflock ")


# --- Completion ---------------------------------------------------------------------------------


def shell_with_posflock(folder: Path) -> dict[str, str]:
    """An environment in which `posflock` is this one."""
    program = folder / "bin" / "posflock"
    program.parent.mkdir()
    call = "import sys; from posflock_robotarium.cli import main; sys.argv[0] = 'posflock'; main()"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -c "{call}" "$@"\n')
    program.chmod(0o755)
    return {**os.environ, "PATH": f"{program.parent}{os.pathsep}{os.environ['PATH']}"}


def test_bash_completes_commands_and_options(tmp_path):
    if shutil.which("bash") is None:
        pytest.skip("no bash")
    environment = shell_with_posflock(tmp_path)
    program = """
eval "$(_POSFLOCK_COMPLETE=source_bash posflock)"
ask() {
    COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=()
    $function posflock; echo "${COMPREPLY[@]}"
}
function=$(complete -p posflock | sed 's/.*-F \\([^ ]*\\).*/\\1/')
ask posflock re
ask posflock report --la
ask posflock profile --js
"""
    done = subprocess.run(
        ["bash", "-c", program], env=environment, capture_output=True, text=True, check=False
    )
    assert done.stderr == ""
    commands, latex, as_json = done.stdout.splitlines()
    assert {"report", "replay", "rehearse", "reproduce"} <= set(commands.split())
    assert set(latex.split()) == {"--latex", "--layout"} & set(latex.split())
    assert "--latex" in latex
    assert as_json == "--json"


@pytest.mark.parametrize(
    ("shell", "asked"),
    [("zsh", {"_TYPER_COMPLETE_ARGS": "posflock rep"}),
     ("fish", {"_TYPER_COMPLETE_ARGS": "posflock rep", "_TYPER_COMPLETE_FISH_ACTION": "get-args"})],
)  # fmt: skip
def test_zsh_and_fish_are_answered(shell, asked, tmp_path):
    environment = shell_with_posflock(tmp_path)
    for instruction, expected in ((f"source_{shell}", "posflock"), (f"complete_{shell}", "report")):
        told = subprocess.run(
            ["posflock"], env=environment | asked | {"_POSFLOCK_COMPLETE": instruction},
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert expected in told.stdout, told


# --- Pipes and encodings ------------------------------------------------------------------------


def piped_into_nobody(command: str, cwd: Path) -> tuple[int, str]:
    # The reader is gone before the first byte.
    program = f"exec 3> >(exec true); sleep 0.3; {command} >&3; echo $?"
    done = subprocess.run(
        ["bash", "-c", program], cwd=cwd, capture_output=True, text=True, check=False
    )
    return int(done.stdout.split()[-1]), done.stderr


@pytest.mark.skipif(os.name == "nt", reason="pipes have no signal there")
@pytest.mark.parametrize("words", ["--help", "profile", "lint turning.py", "run turning.py"])
def test_a_reader_that_is_gone_ends_a_command_quietly(words, script):
    command = f"'{sys.executable}' -m posflock_robotarium {words}"
    code, complaint = piped_into_nobody(command, script.parent)
    assert code == 141
    assert "Traceback" not in complaint
    assert "BrokenPipe" not in complaint


@pytest.mark.parametrize(
    "env",
    [
        {"PYTHONIOENCODING": "cp1252"},
        pytest.param({"PYTHONIOENCODING": "ascii"}, marks=pytest.mark.slow),
        pytest.param({"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
                     marks=pytest.mark.slow),
    ],
    ids=["cp1252", "ascii", "C"],
)  # fmt: skip
def test_what_cannot_be_shown_is_replaced(env, script):
    for words in (["--help"], ["run", "--help"], ["run", "turning.py"]):
        done = ran(*words, env=env, cwd=script.parent)
        assert done.returncode == 0, done.stderr
        assert b"Traceback" not in done.stderr
    assert b"\\u03b3 = 1" in done.stdout


# --- Whose options ------------------------------------------------------------------------------


def test_options_after_a_script_that_reads_none_are_posflocks(script):
    done = ran("run", script.name, "-o", "out", "--headless", cwd=script.parent)
    assert done.returncode == 0, done.stderr
    assert (script.parent / "out" / "report.json").exists()


def test_a_script_that_refuses_our_option_is_told_of_its_place(script):
    script.write_text("import argparse\nargparse.ArgumentParser().parse_args()\n" + TURNING)
    done = ran("run", script.name, "-o", "out", cwd=script.parent)
    assert done.returncode == 2
    assert b"put posflock's options before it" in done.stderr


def test_what_a_script_reads_is_left_to_it(script):
    script.write_text("import sys\nprint(sys.argv[1:])\n" + TURNING)
    done = ran("run", script.name, "--seed", "3", cwd=script.parent)
    assert b"['--seed', '3']" in done.stdout


def test_arguments_may_be_read_by_a_file_beside(tmp_path):
    (tmp_path / "main.py").write_text("import chosen\n")
    (tmp_path / "chosen.py").write_text("import sys\nseed = int(sys.argv[1])\n")
    assert may_read_arguments(tmp_path / "main.py")
    (tmp_path / "chosen.py").write_text("seed = 1\n")
    assert not may_read_arguments(tmp_path / "main.py")
    assert may_read_arguments(tmp_path / "nowhere.py")


# --- For programs -------------------------------------------------------------------------------


def test_replay_convert_and_profile_speak_json(tmp_path):
    from documented_commands import FILES

    FILES["simulated.npy"](tmp_path / "log.npy")
    words = ["convert", tmp_path / "log.npy", "--to", "csv", "-o", tmp_path / "new/one.csv"]
    told = CliRunner().invoke(app, [*map(str, words), "--json"])
    found = json.loads(told.stdout)
    assert Path(found["file"]).stat().st_size == found["bytes"]
    assert (found["rows"], found["robots"]) == (900, 4)
    film = ["replay", tmp_path / "log.npy", "--video", tmp_path / "new/er/one.gif", "--speed", "30"]
    told = CliRunner().invoke(app, [*map(str, film), "--json"])
    assert told.exit_code == 0, told.output
    assert Path(json.loads(told.stdout)["file"]).exists()
    profile = json.loads(CliRunner().invoke(app, ["profile", "gternal", "--json"]).stdout)
    assert profile["name"]
