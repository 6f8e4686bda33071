"""What has to change in a script before the testbed of today runs it, with line numbers.

*Names* that generation 2 of the API or the testbed's libraries and Python do not have
(:mod:`rps_compat.scripts.uses`, which ``posflock verify`` reads as well). *Defaults*: arguments
that a script of generation 1 leaves out and that generation 2 fills in differently, so that the
same line does something else. *Arguments* that have other names or places, or mean something else.

Most findings come with edits; see :mod:`rps_compat.scripts.edits`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from rps_compat.porting import ChangeKind, Porting
from rps_compat.scripts import edits as editing
from rps_compat.scripts.api import ApiName, Role
from rps_compat.scripts.changes import Change, Kind
from rps_compat.scripts.edits import Edit, Text
from rps_compat.scripts.evidence import evidence_of
from rps_compat.scripts.interpretation import interpret
from rps_compat.scripts.renaming import Renaming
from rps_compat.scripts.source import Script, parse_script, read_script
from rps_compat.scripts.uses import Use, uses_in

#: The generation that scripts are rewritten for.
TARGET: Literal[2] = 2


@dataclass(frozen=True)
class LintFinding:
    """Something to change.

    Attributes
    ----------
    line
        Where, counted from 1.
    kind
        What has to be changed.
    message
        What is wrong and what is right.
    edits
        What rewriting does about it; none where a person has to decide.
    file
        Name of the file beside the script that it stands in; "" for the script itself.
    """

    line: int
    kind: ChangeKind
    message: str
    edits: tuple[Edit, ...] = ()
    file: str = ""

    @property
    def needed(self) -> bool:
        """Whether the testbed needs the change."""
        return self.kind is not ChangeKind.LATER

    @property
    def by_hand(self) -> bool:
        """Whether a person has to make it: rewriting does not."""
        return self.needed and self.kind is not ChangeKind.DEFAULT and not self.edits


def findings_of(script: Script) -> list[LintFinding]:
    """List what has to change in a script and in the modules beside it, by file and line.

    Parameters
    ----------
    script : Script
        The script, as read.
    """
    program = interpret(script)
    uses = [use for use in uses_in(program) if not use.ready and _is_told(use)]
    evidence = evidence_of(uses)
    text = Text(script)
    renaming = Renaming(program, text, TARGET)
    # Names first, then calls from the inside out: the outer are made from what the inner become.
    edits = {
        use: renaming.edits(use) for use in uses if not use.module.name and use.matters(TARGET)
    }
    porting = Porting(
        program,
        text,
        renaming,
        second=evidence.generation == TARGET,
        older=evidence.is_older,
    )
    ported = porting.run()
    found = []
    for use in uses:
        its = (*edits.get(use, ()), *porting.edits_at.get(use.node, ()))
        file = use.module.script.path.name if use.module.name else ""
        message = f"{use.what}; {use.remedy(TARGET)}"
        found.append(LintFinding(use.line, _kind_of(use), message, its, file))
    found += [LintFinding(p.line, p.kind, p.message, p.edits) for p in ported]
    return _merged(found)


def findings_in(source: bytes, name: str = "script") -> list[LintFinding]:
    """List what has to change in the bytes of a script.

    Parameters
    ----------
    source : bytes
        The script's text.
    name : str
        What the error calls it.

    Raises
    ------
    UnreadableError
        `source` is not Python; `name` says whose.
    """
    return findings_of(parse_script(source, name))


def rewritten(script: Script, findings: list[LintFinding]) -> bytes:
    """Return the script with the edits of all `findings` made; the rest stays as it was.

    Parameters
    ----------
    script : Script
        The script, as read.
    findings : list of LintFinding
        What is changed.
    """
    return editing.rewritten(script, [edit for finding in findings for edit in finding.edits])


def lint_script(path: Path) -> tuple[Script, list[LintFinding]]:
    """Read a script and list its findings.

    Parameters
    ----------
    path : Path
        The script's file.

    Raises
    ------
    ScriptError
        There is no such script.
    UnreadableError
        It is not Python.
    """
    script = read_script(path)
    return script, findings_of(script)


def _is_told(use: Use) -> bool:
    """Whether a use is a finding: what generation 2 has is none."""
    return not isinstance(use.entry, ApiName) or use.matters(TARGET)


def _kind_of(use: Use) -> ChangeKind:
    if isinstance(use.entry, ApiName):
        argument = use.entry.role in (Role.ARGUMENT, Role.POSITIONAL)
        return ChangeKind.ARGUMENT if argument else ChangeKind.NAME
    if isinstance(use.entry, Change) and use.entry.kind is Kind.LATER:
        return ChangeKind.LATER
    return ChangeKind.VERSION


def _merged(found: list[LintFinding]) -> list[LintFinding]:
    """Tell what is wrong several times in one line once, with all its edits."""
    merged: dict[tuple[str, int, str, str], LintFinding] = {}
    for finding in found:
        key = finding.file, finding.line, finding.message, finding.kind
        edits = merged[key].edits if key in merged else ()
        more = tuple(edit for edit in finding.edits if edit not in edits)
        merged[key] = replace(finding, edits=edits + more)
    return [merged[key] for key in sorted(merged)]
