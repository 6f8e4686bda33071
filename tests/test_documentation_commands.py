"""Every shell command that the documentation shows is one that works."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import documented_commands as documented
import pytest
import typer
from documented_commands import PAGES, ROOT

from posflock_robotarium.cli import app
from posflock_robotarium.examples import copy_examples

GROUP = typer.main.get_command(app)
WITH_COMMANDS = [page for page in PAGES if documented.commands(page)]


def admitted(words: list[str]) -> None:
    """Let the command line read words without doing what they say; it raises what it refuses."""
    name, *rest = words
    GROUP.commands[name].make_context(name, list(rest))


@pytest.mark.parametrize("page", WITH_COMMANDS, ids=lambda page: page.name)
def test_options_that_a_page_shows_are_there(page):
    for command in documented.commands(page):
        program, *words = shlex.split(command.words)
        if program == "posflock":
            admitted(words)


@pytest.mark.parametrize("name", sorted(GROUP.commands))
def test_options_that_the_examples_of_help_show_are_there(name):
    shown = re.findall(r"^    posflock (.*)$", GROUP.commands[name].help, re.M)
    assert shown
    for words in shown:
        admitted(shlex.split(re.sub(r" > .*", "", words)))


def test_every_target_of_make_that_is_shown_is_one():
    targets = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.M))
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        assert set(re.findall(r"`make ([\w-]+)`", text)) <= targets, page
        for command in documented.commands(page):
            program, *words = shlex.split(command.words)
            if program == "make":
                assert {word for word in words if "=" not in word} <= targets


def test_tests_that_run_commands_elsewhere_are_there():
    for by in (*documented.ELSEWHERE.values(), *documented.PAGES_ELSEWHERE.values()):
        assert (ROOT / "tests" / by.partition(":")[0]).exists()


def test_every_page_with_a_fence_names_its_language():
    for page in PAGES:
        opened = False
        for line in page.read_text(encoding="utf-8").splitlines():
            if line.startswith("```"):
                opened = not opened
                assert not opened or line in SHOWN or page.name == "architecture.md", (page, line)


#: Languages of fences: commands, examples, and files that a command beside them takes.
SHOWN = {"```sh", "```console", "```python", "```py", "```toml", "```text"}


def run_page(page: Path, folder: Path) -> None:
    documented.supply(page, folder)
    copy_examples(folder / "experiments")
    write_named_files(page, folder)
    tools = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": tools, "MPLBACKEND": "agg"}
    for command in documented.commands(page):
        if command.elsewhere:
            continue
        done = subprocess.run(
            ["bash", "-c", command.light], cwd=folder, env=environment,
            capture_output=True, text=True, check=False, encoding="utf-8",
        )  # fmt: skip
        assert done.returncode in command.exit_codes, f"{command.words}\n{done.stderr}"
        assert "Traceback" not in done.stderr, done.stderr
        for line in command.shown:
            said = [" ".join(word.split()) for word in done.stdout.splitlines()]
            assert " ".join(line.split()) in said, f"{command.words}\n{done.stdout}"


def write_named_files(page: Path, folder: Path) -> None:
    """Write the blocks of a page whose first line is the name of a file."""
    blocks = re.findall(r"^```\w+\n# (\w+\.\w+)\n(.*?)^```", page.read_text("utf-8"), re.M | re.S)
    for name, content in blocks:
        (folder / name).write_text(shortened(content), encoding="utf-8")


def shortened(study: str) -> str:
    return study.replace("replications = 10000", "replications = 2")


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [page for page in WITH_COMMANDS if page.name not in documented.PAGES_ELSEWHERE],
    ids=lambda page: page.name,
)
def test_commands_of_a_page_run_in_order(page, tmp_path):
    run_page(page, tmp_path)
