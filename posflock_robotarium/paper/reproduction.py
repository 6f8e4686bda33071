"""Go through the reproduction from seeds to files."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from posflock_robotarium.flocking.errors import OutputError
from posflock_robotarium.freespace.simulation import FreeSpace
from posflock_robotarium.paper.claim import Judgement, Result
from posflock_robotarium.paper.claims import judge_all
from posflock_robotarium.paper.default_seeds import SEEDS
from posflock_robotarium.paper.evidence import Evidence
from posflock_robotarium.paper.gathering import gather
from posflock_robotarium.paper.tables import over_seeds, qualitative, varied
from rps_compat.whole_files import write_whole, written_together


@dataclass(frozen=True, eq=False)
class Reproduction:
    """What a reproduction found, and where it was written.

    Attributes
    ----------
    evidence : Evidence
        Every run.
    judgements : list of Judgement
        Every claim, judged.
    paths : list of Path
        Figures, tables and ``claims.md``.
    """

    evidence: Evidence
    judgements: list[Judgement]
    paths: list[Path]

    @property
    def verdicts(self) -> Counter[Result]:
        """How many claims got each verdict."""
        return Counter(judgement.verdict for judgement in self.judgements)


def reproduce(
    folder: Path,
    seeds: int = SEEDS,
    *,
    first_seed: int = 0,
    paper: FreeSpace | None = None,
    driving: float = 120.0,
    workers: int | None = None,
    progress: Callable[[int, int], None] = lambda done, all_: None,
) -> Reproduction:
    """Recompute the paper into `folder`: figures, tables, claims.

    Parameters
    ----------
    folder : Path
        Made where missing: ``figures/`` (PDF and PNG), ``claims.md``, ``claims.json``,
        ``tables.md`` and one CSV a table.
    seeds, first_seed : int
        How many seeds, counted up from the first.
    paper, driving : FreeSpace, float
        A smaller simulation and a shorter drive, s, make a quick rehearsal.
    workers : int, optional
        Processes; one for each processor by default.
    progress : function of (done, all)
        Called after each finished task.

    Returns
    -------
    Reproduction
        On one machine the same bytes for the same seeds, except for the versions of libraries.

    Raises
    ------
    OutputError
        Where `folder` cannot be written; this is tried before anything is computed.
    ParameterError
        Where `seeds` is less than 2.
    """
    from posflock_robotarium.paper.paper_figures import draw_all

    _require_folder(folder)
    evidence = gather(
        seeds,
        first_seed=first_seed,
        paper=paper,
        driving=driving,
        workers=workers,
        progress=progress,
    )
    judgements = judge_all(evidence)
    with written_together(folder) as draft:
        paths = [
            write_whole(draft / name, text.rstrip("\n") + "\n")
            for name, text in _texts(evidence, judgements).items()
        ]
        paths += draw_all(evidence, draft / "figures")
    return Reproduction(evidence, judgements, [folder / p.relative_to(draft) for p in paths])


def _texts(evidence: Evidence, judgements: list[Judgement]) -> dict[str, str]:
    """Return claims and tables as text, by the name of the file."""
    tables = {
        "table_seeds": over_seeds(evidence),
        "table_qualitative": qualitative(evidence),
        "table_variations": varied(evidence),
    }
    return {
        "claims.md": claims_page(judgements, evidence),
        "claims.json": json.dumps([j.as_dict() for j in judgements], indent=2, ensure_ascii=False),
        "tables.md": "\n".join(["# Tables", "", *(table.markdown() for table in tables.values())]),
        **{f"{name}.csv": table.csv() for name, table in tables.items()},
    }


def claims_page(judgements: list[Judgement], evidence: Evidence) -> str:
    """Return ``claims.md``: a table of verdicts, then each claim with its test and reason.

    Parameters
    ----------
    judgements : list of Judgement
        What became of each claim.
    evidence : Evidence
        Every run of the reproduction.
    """
    first, last = evidence.seeds[0], evidence.seeds[-1]
    counted = Counter(judgement.verdict for judgement in judgements)
    lines = [
        "# The paper's claims, tested",
        "",
        f"{len(judgements)} sentences over seeds {first} to {last} ({len(evidence.seeds)} runs of"
        " each model and of the robots): "
        + ", ".join(f"{counted[v]} {v.mark} {v.value}" for v in Result)
        + ".",
        "",
        "Verdicts are computed from the thresholds stated with each claim, and from 95 % intervals,"
        " in brackets: Wilson's of shares, bootstrapped of medians.  A claim *holds* where the"
        " whole interval is at or beyond its threshold, *holds weakly* where it is at or beyond the"
        " weaker one, *does not hold* where it is before that, and is *not settled* where that is"
        " within it.  Numbers without brackets are changed by no seed.",
        "",
        "| | claim | measured | verdict |",
        "| --- | --- | --- | --- |",
    ]
    for judgement in judgements:
        claim = judgement.claim
        lines.append(
            f"| {judgement.verdict.mark} | [{claim.id}](#{claim.id}) |"
            f" {judgement.measured.text} {claim.unit} | {judgement.verdict.value} |"
        )
    for judgement in judgements:
        claim = judgement.claim
        lines += ["", f"## {claim.id}", "", f"> {claim.claim}", "", f"**Test:** {claim.test}."]
        lines += ["", f"**{judgement.verdict.value.capitalize()}.** {judgement.reason}"]
    return "\n".join(lines)


def _require_folder(folder: Path) -> None:
    """Make the folder, or refuse before minutes of computing are lost."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".writable"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise OutputError(f"cannot write into {folder}: {error.strerror}") from error
