"""Options of ``posflock watch`` that no other command has."""

from pathlib import Path
from typing import Annotated

import typer

WatchSpeed = Annotated[
    str,
    typer.Option(
        metavar="FACTOR",
        help="Times as fast as real time: 0.25, 0.5, 1, 2, 4, 8, or max. The page changes it.",
    ),
]
StartPaused = Annotated[bool, typer.Option("--paused", help="Hold it in its first step.")]
WatchRadius = Annotated[
    float | None,
    typer.Option(
        help="Metres within which robots are neighbours, for scripts that fly no flock of ours.",
        show_default=False,
    ),
]
Port = Annotated[int, typer.Option(min=0, max=65535, help="To serve at; 0 takes a free one.")]
OpenPage = Annotated[
    bool | None,
    typer.Option("--open/--no-open", help="Open a browser. Default where there is a display."),
]
Stay = Annotated[
    bool, typer.Option(help="Keep the page when the script has ended; else end with it.")
]
WatchFolder = Annotated[
    Path | None,
    typer.Option("-o", "--out", help="Folder for what the run leaves. Default: it leaves nothing."),
]
