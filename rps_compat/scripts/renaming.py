"""The edits that give a name of the API or of a library the name that the testbed has for it."""

from __future__ import annotations

import ast
import re

from rps_compat.scripts.api import ApiName, Role, brings, import_of
from rps_compat.scripts.changes import Change
from rps_compat.scripts.edits import Edit, Text
from rps_compat.scripts.faces import has
from rps_compat.scripts.generation_names import (
    FIRST_OF_TWO,
    MADE_FIRST,
    OLD_AT_ONCE,
    OTHER_SHAPE,
    counterpart,
)
from rps_compat.scripts.program import Program
from rps_compat.scripts.uses import Use

#: Something that has moved into a module within its module.
_MOVED = re.compile(r"\{\}((?:\.\w+)+)\.(\w+)")


class Renaming:
    """Makes the edits that mend single names of a script.

    Parameters
    ----------
    program : Program
        The script and the modules beside it.
    text : Text
        Where the edits are made.
    generation : int
        The generation of the API that it is rewritten for.
    """

    def __init__(self, program: Program, text: Text, generation: int = 2) -> None:
        self._program, self._text, self._generation = program, text, generation
        tree = program.main.script.tree
        self._called = {node.func for node in ast.walk(tree) if isinstance(node, ast.Call)}
        self._imports = {
            alias: node
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom)
            for alias in node.names
        }

    def edits(self, use: Use) -> tuple[Edit, ...]:
        """Return the edits that mend one use; none where a call or a person has to.

        Parameters
        ----------
        use : Use
            A name that the testbed lacks, where the script uses it.
        """
        if isinstance(use.entry, Change):
            return self._of_change(use.node, use.entry)
        if not isinstance(use.entry, ApiName):
            return ()
        role, node = use.entry.role, use.node
        if role is Role.STAR:
            return self._imported(import_of(use.entry.name, self._generation))
        right = use.entry.right(self._generation)
        first = counterpart(use.entry.name, 1) or use.entry.name
        if right is None or first in OTHER_SHAPE:
            return ()
        if role is Role.ATTRIBUTE and isinstance(node, ast.Attribute):
            return (self._text.rename(node, right),)
        if role is Role.FUNCTION:
            return self._of_function(node, use.entry.name, right)
        return ()

    def _of_function(self, node: ast.AST, name: str, right: str) -> tuple[Edit, ...]:
        if isinstance(node, ast.alias):
            module = self._imports[node].module or ""
            if not has(module, right, self._generation):
                return ()
            return (self._text.rename(node, right),)
        if (
            not isinstance(node, (ast.Name, ast.Attribute))
            or name in MADE_FIRST
            or (name in OLD_AT_ONCE)
        ):
            return ()
        if name in FIRST_OF_TWO and node not in self._called:
            return ()
        edits: tuple[Edit, ...] = (self._text.rename(node, right),)
        if isinstance(node, ast.Name) and node in self._program.starred:
            edits += self.brought(right)
        return edits

    def brought(self, name: str) -> tuple[Edit, ...]:
        """Return the import of a function that no star of the script brings; none if one does.

        Parameters
        ----------
        name : str
            Name of the function in the new generation.
        """
        stars = self._program.main.stars
        if any(brings(star, name, self._generation) for star in stars):
            return ()
        return self._imported(import_of(name, self._generation))

    def _imported(self, line: str) -> tuple[Edit, ...]:
        """Put an import behind the last star of the API's modules."""
        stars = [
            node
            for alias, node in self._imports.items()
            if alias.name == "*" and (node.module or "").partition(".")[0] == "rps"
        ]
        place = self._text.line_after(stars[-1]) if stars else None
        if place is None:
            return ()
        at, indent = place
        return (self._text.make(at, at, f"{self._text.newline}{indent}{line}"),)

    def _of_change(self, node: ast.AST, change: Change) -> tuple[Edit, ...]:
        code = change.code
        if not code or (code.isidentifier() and self._is_own(code)):
            return ()
        if isinstance(node, ast.Attribute):
            written = change.written(self._text.of(node.value))
            return (self._text.replace(node, written),)
        if isinstance(node, ast.Name):
            return self._of_name(node, change)
        if isinstance(node, ast.alias) and node in self._imports:
            return self._of_import(node, code)
        return ()

    def _of_name(self, node: ast.Name, change: Change) -> tuple[Edit, ...]:
        """Edit a name that a star brought, or one whose import is edited as well."""
        if "{}" not in change.code:
            return (self._text.rename(node, change.written("")),)
        alone = any(
            alias.name == node.id and len(statement.names) == 1
            for alias, statement in self._imports.items()
        )
        moved = _MOVED.fullmatch(change.code)
        if moved is None or not alone or moved[2] == node.id:
            return ()
        return (self._text.rename(node, moved[2]),)

    def _of_import(self, alias: ast.alias, code: str) -> tuple[Edit, ...]:
        """``from numpy import mat``, and ``from scipy.signal import hann``, which has moved."""
        if code.startswith("."):
            return (self._text.rename(alias, code[1:]),)
        moved = _MOVED.fullmatch(code)
        statement = self._imports[alias]
        if moved is None or len(statement.names) > 1 or not statement.module:
            return ()
        start = self._text.start(statement)
        written = re.match(r"from\s+", self._text.of(statement))
        assert written is not None
        at = start + written.end() + len(statement.module)
        edits = (self._text.make(at, at, moved[1]),)
        return edits if moved[2] == alias.name else (*edits, self._text.rename(alias, moved[2]))

    def _is_own(self, name: str) -> bool:
        """Whether the script calls something else by the name of one of Python's own."""
        return name in self._program.main.scope.ever
