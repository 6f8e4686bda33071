"""How ``--help`` looks: whole at any width, as plain text that any terminal can show.

Tables with frames cut words off once a terminal is narrow, and need characters that not every
terminal has. Here a page is text, wrapped at words; an option says what it takes in one word
(``INTEGER``, ``FOLDER``); an example that is too long for its line goes on in the next, as a shell
takes it.
"""

import re
from typing import TYPE_CHECKING, Any

from typer.core import TyperCommand, TyperGroup

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

_INDENT = 2
#: What a value is called, by a part of the name of its type; whatever is none of them is TEXT.
_METAVARS = {
    "int": "INTEGER",
    "float": "NUMBER",
    "path": "PATH",
    "file": "PATH",
    "directory": "PATH",
    "bool": "",
}


class CommandPage(TyperCommand):
    """A command whose help is whole at any width."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the page.

        Parameters
        ----------
        ctx : click.Context
            Of the call.
        formatter : click.HelpFormatter
            Which takes the text and knows the width.
        """
        _write_page(self, ctx, formatter)


class GroupPage(TyperGroup):
    """The list of commands, under the headings that they are registered with."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the page.

        Parameters
        ----------
        ctx : click.Context
            Of the call.
        formatter : click.HelpFormatter
            Which takes the text and knows the width.
        """
        _write_page(self, ctx, formatter)
        headings: dict[str, list[tuple[str, str]]] = {}
        for name in self.list_commands(ctx):
            command: Any = self.get_command(ctx, name)
            if not command.hidden:
                heading = getattr(command, "rich_help_panel", None) or "Commands"
                headings.setdefault(heading, []).append((name, _first_paragraph(command.help)))
        for heading, rows in headings.items():
            with formatter.section(heading):
                formatter.write_dl(rows)


def _write_page(command: Any, ctx: Any, formatter: Any) -> None:
    formatter.write_usage(ctx.command_path, _usage(command, ctx))
    for paragraph in re.split(r"\n\s*\n", command.help or ""):
        formatter.write_paragraph()
        if paragraph.startswith("    "):
            for line in shell_lines(paragraph.strip(), formatter.width - 2 * _INDENT):
                formatter.write(f"{'':{2 * _INDENT}}{line}\n")
        else:
            with formatter.indentation():
                formatter.write_text(re.sub(r"\[/?bold\]", "", " ".join(paragraph.split())))
    sections: dict[str, list[tuple[str, str]]] = {"Arguments": [], "Options": []}
    for parameter in command.get_params(ctx):
        record = parameter.get_help_record(ctx)
        if record is not None:
            of = "Arguments" if parameter.param_type_name == "argument" else "Options"
            sections[of].append((_asked(parameter), record[1]))
    for title, rows in sections.items():
        if rows:
            with formatter.section(title):
                formatter.write_dl(rows)


def _usage(command: Any, ctx: Any) -> str:
    """Return what follows a command's name, arguments that may be left out in brackets."""
    words = ["[OPTIONS]"]
    for parameter in command.get_params(ctx):
        if parameter.param_type_name == "argument":
            name = _asked(parameter)
            words.append(name if parameter.required else f"[{name}]")
    if hasattr(command, "list_commands"):
        words.append("COMMAND [ARGS]...")
    elif command.allow_extra_args:
        words.append("[ARGS]...")
    return " ".join(words)


def shell_lines(command: str, width: int) -> "Iterator[str]":
    r"""Yield a command in lines that a shell joins again, none longer than `width` if words allow.

    Parameters
    ----------
    command : str
        Words, as a shell takes them.
    width : int
        Of a line, in characters.

    Examples
    --------
    >>> list(shell_lines("posflock report results/nine_robots.npy -o report", 42))
    ['posflock report results/nine_robots.npy \\', '    -o report']
    """
    line = ""
    for words in _kept_together(command.split()):
        if line.strip() and len(line) + len(words) + 3 > width:
            yield f"{line} \\"
            line = "   "
        line = f"{line} {words}" if line else words
    yield line


def _kept_together(words: "Iterable[str]") -> "Iterator[str]":
    """Yield words, an option with what follows it."""
    option = ""
    for word in words:
        if word.startswith("-"):
            if option:
                yield option
            option = word
        else:
            yield f"{option} {word}".strip()
            option = ""
    if option:
        yield option


def _asked(parameter: Any) -> str:
    """Return how a parameter is given: its names, and a word for its value."""
    if parameter.param_type_name == "argument":
        name = parameter.metavar or str(parameter.name).upper()
        return f"{name}..." if parameter.nargs != 1 and not name.endswith("...") else name
    names = ", ".join(sorted(parameter.opts, key=len))
    if parameter.secondary_opts:
        names += " / " + ", ".join(parameter.secondary_opts)
    return names if parameter.is_flag else f"{names} {parameter.metavar or _metavar(parameter)}"


def _metavar(parameter: Any) -> str:
    """Return a word for what an option takes, from what its type calls itself."""
    described = getattr(parameter, "type", None)
    name = getattr(described, "name", "") or str(
        getattr(getattr(parameter, "type_descriptor", None), "annotation", "")
    )
    return next((word for part, word in _METAVARS.items() if part in name.lower()), "TEXT")


def _first_paragraph(text: str | None) -> str:
    return " ".join(re.split(r"\n\s*\n", text or "")[0].split())
