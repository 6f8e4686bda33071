"""Which generation of the API a script was written for.

A script of a generation dies under the other at the first name that only its own has. So the names
are counted that would stop it under each: the generation that fewer stop is the likelier, and where
that does not tell, generation 2, which the testbed runs. Names that the script asks for before it
uses them (``hasattr``, ``try``) stop it nowhere, and tell nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from rps_compat.generations import Generation
from rps_compat.scripts.api import ApiName
from rps_compat.scripts.interpretation import read_program
from rps_compat.scripts.program import Program
from rps_compat.scripts.uses import Use, uses_in

#: Names of the other generation beyond this many are counted only.
TOLD = 5


@dataclass(frozen=True)
class GenerationEvidence:
    """What in a script speaks for which generation.

    Attributes
    ----------
    uses : tuple of Use
        Names of the API that not all generations have, by file and line.
    """

    uses: tuple[Use, ...] = ()

    def stopping(self, generation: Generation) -> list[Use]:
        """Return the names at which the script stops.

        Parameters
        ----------
        generation : int
            Of the API: 1 or 2.
        """
        return [use for use in self.uses if use.stops(generation) and not use.follows]

    @property
    def generation(self) -> Generation:
        """The likelier generation; without evidence 2, which the testbed runs."""
        return 1 if len(self._own(1)) < len(self._own(2)) else 2

    def _own(self, generation: Generation) -> set[str]:
        """Names that stop the script as `generation`, and not as the other."""
        other: Generation = 1 if generation == 2 else 2
        return {
            use.entry.shown
            for use in self.stopping(generation)
            if isinstance(use.entry, ApiName) and not use.entry.stops(other)
        }

    @property
    def certain(self) -> bool:
        """Whether names of one generation stop the script under the other, and not vice versa."""
        return bool(self._own(1)) != bool(self._own(2))

    @property
    def nothing(self) -> bool:
        """Whether no name in it tells anything."""
        return not self.uses

    @property
    def is_older(self) -> bool:
        """Whether it is of the API of 2017 to 2019, before generation 1."""
        return any(isinstance(u.entry, ApiName) and u.entry.generations == {0} for u in self.uses)

    def against(self, generation: Generation) -> list[str]:
        """Say what stops the script, and what is right there.

        Parameters
        ----------
        generation : int
            Of the API: 1 or 2.
        """
        return [
            f"{place(use)}: {use.what}; {use.remedy(generation)}"
            for use in self.stopping(generation)
        ]

    def notes(self, generation: Generation, found: bool) -> list[str]:
        """Return what is to be known before the script runs as `generation`.

        Parameters
        ----------
        generation : int
            1 or 2.
        found : bool
            Whether it was read off the script, and not asked for.
        """
        wrong = self.against(generation)
        other = 3 - generation
        notes = wrong[:TOLD]
        if len(wrong) > TOLD:
            notes.append(f"and {len(wrong) - TOLD} more names that generation {generation} has not")
        if found and self.nothing:
            notes.append(
                f"nothing in the script tells its generation: running as generation {generation}; "
                f"--generation {other} runs it as generation {other}"
            )
        return notes


def place(use: Use) -> str:
    """Return where a use stands: the line, and the file where that is not the script.

    Parameters
    ----------
    use : Use
        A name that not everybody has, where the script uses it.
    """
    name = use.module.script.path.name if use.module.name else ""
    return f"{name} line {use.line}".strip()


def evidence_of(uses: Iterable[Use]) -> GenerationEvidence:
    """Return what among all `uses` of a script is evidence.

    Parameters
    ----------
    uses : iterable of Use
        All uses of a script.
    """
    return GenerationEvidence(tuple(use for use in uses if isinstance(use.entry, ApiName)))


def evidence_in(script: Path | Program) -> GenerationEvidence:
    """Read what speaks for which generation in a script and the modules beside it.

    Parameters
    ----------
    script : Path or Program
        The script's file, or what was read of it.

    Raises
    ------
    ScriptError
        There is no such script.
    UnreadableError
        It is not Python.
    """
    program = script if isinstance(script, Program) else read_program(script)
    return evidence_of(uses_in(program))
