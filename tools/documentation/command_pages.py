"""A page with the help of every command, as a terminal shows it."""

from __future__ import annotations

import typer
from typer.testing import CliRunner

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
    plain = {"COLUMNS": "88", "TERM": "dumb", "NO_COLOR": "1"}
    said = CliRunner().invoke(app, [*words, "--help"], prog_name="posflock", env=plain)
    return "\n".join(line.rstrip() for line in said.stdout.strip().splitlines()) + "\n"
