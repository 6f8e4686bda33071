"""Options by which a report is asked one's own question: metrics, targets, references."""

from pathlib import Path
from typing import Annotated

import typer

OwnMetrics = Annotated[
    list[str] | None,
    typer.Option(
        "--metric",
        metavar="FILE.py:NAME",
        help="A metric of your own: a function of the run, called in this process; repeatable.",
        show_default=False,
    ),
]
QuestionsAsked = Annotated[
    str | None,
    typer.Option(
        "--questions",
        metavar="flocking|formation|coverage|none",
        help="What is asked beside safety, limits and certainty. Default: flocking of a log that "
        "says a neighbour radius, or with --radius; else none.",
        show_default=False,
    ),
]
TargetsAsked = Annotated[
    list[str] | None,
    typer.Option(
        "--target",
        metavar="TARGET",
        help="A verdict of your own, as 'formation_error < 0.05 m for 95 % of the time', "
        "'… always', '… on average', '… at the end', each with 'after 20 s' or without; "
        "repeatable.",
        show_default=False,
    ),
]
ReferenceRun = Annotated[
    Path | None,
    typer.Option(
        "--reference",
        metavar="LOG",
        help="Also tell how far each robot is from where it is in this run (APE and RPE, as evo).",
        show_default=False,
    ),
]
ReferenceDelta = Annotated[
    float,
    typer.Option("--delta", metavar="SECONDS", help="Over which the RPE looks at motion."),
]
ReferenceOffset = Annotated[
    float,
    typer.Option(
        "--reference-offset",
        metavar="SECONDS",
        help="By how much later than the runs the reference began.",
    ),
]
