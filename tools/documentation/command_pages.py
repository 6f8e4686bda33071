"""A page with the help of every command, as a terminal shows it."""

from __future__ import annotations

import os
import subprocess
import sys

import typer

from posflock_robotarium.cli import app

_PAGE = """\
# Commands

What `posflock --help` and `posflock COMMAND --help` say.

"""


def command_page() -> dict[str, str]:
    """Return the text of the page, by its path below the root of the site."""
    group = typer.main.get_command(app)
    text = [_PAGE, f"``````text\n{_help()}``````\n"]
    for name in sorted(group.commands):  # type: ignore[attr-defined]
        text.append(f"\n## posflock {name}\n\n``````text\n{_help(name)}``````\n")
    return {"reference/commands.md": "".join(text)}


def _help(*words: str) -> str:
    environment = os.environ | {"COLUMNS": "88", "TERM": "dumb", "NO_COLOR": "1"}
    done = subprocess.run(
        [sys.executable, "-m", "posflock_robotarium", *words, "--help"],
        env=environment, capture_output=True, check=True, text=True, encoding="utf-8",
    )  # fmt: skip
    return "\n".join(line.rstrip() for line in done.stdout.strip().splitlines()) + "\n"
