"""``posflock reproduce``: the paper's figures, tables and claims, recomputed."""

from pathlib import Path
from typing import Annotated

import typer

from posflock_robotarium.commands import options
from posflock_robotarium.commands.terminal import say
from posflock_robotarium.paper.default_seeds import SEEDS


def reproduce(
    seeds: Annotated[
        int, typer.Option(min=2, help="Runs of each model and of the robots; few rehearse quickly.")
    ] = SEEDS,
    seed: options.FirstSeed = 0,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for all files.")] = Path(
        "results/paper"
    ),
    jobs: options.Processes = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print claims.json instead.")] = False,
) -> None:
    """Recompute every figure, table and checkable sentence of the paper, and say which hold.

    Writes claims.md, claims.json, tables.md, CSV tables, and figures/ as PDF and PNG.  Verdicts
    follow from 95 % intervals over seeds: few seeds leave claims "not settled".  A claim that
    does not hold is a finding, not an error: the exit code is 0.

    [bold]Examples[/bold]

        posflock reproduce --seed 1000 -o results/other-seeds

        posflock reproduce --seeds 10 -o results/rehearsal
    """
    import json

    from posflock_robotarium.flocking.progress import counted
    from posflock_robotarium.paper.reproduction import reproduce as recompute

    with counted("reproducing the paper") as progress:
        found = recompute(out, seeds, first_seed=seed, workers=jobs, progress=progress)
    if as_json:
        claims = [judgement.as_dict() for judgement in found.judgements]
        say(json.dumps(claims, indent=2, ensure_ascii=False))
        return
    for judgement in found.judgements:
        say(f"{judgement.verdict.value:14} {judgement.claim.id:28} {judgement.measured.text}")
    verdicts = ", ".join(f"{count} {verdict.value}" for verdict, count in found.verdicts.items())
    say(f"{len(found.judgements)} claims: {verdicts}")
    say(f"written: {out}/claims.md, claims.json, tables.md, figures/")
