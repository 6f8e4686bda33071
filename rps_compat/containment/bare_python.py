"""A Python that has the standard library and this package alone: it starts in some ten ms."""

from __future__ import annotations

import sys
from pathlib import Path

# The package around this one is not run: it would import numpy.
_PROGRAM = """\
import os, sys, types
if {owner} not in (None, os.getppid()) or {apart} and os.fork():
    os._exit(0)
package = sys.modules["{package}"] = types.ModuleType("{package}")
package.__path__ = [{folder!r}]
from {package}.containment.{module} import main
main(sys.argv[1:])
"""


def bare_python(
    module: str, *words: str, owner: int | None = None, apart: bool = False
) -> list[str]:
    """Return the command that runs ``main`` of a module of this package in such a Python.

    Parameters
    ----------
    module : str
        Name of the module, without the package's.
    *words : str
        What its ``main`` is given.
    owner : int, optional
        Process id of who must have started it: where that has ended meanwhile, it does nothing.
    apart : bool
        Whether it goes on in a fork of its own and ends at once for whoever has started it, who
        has then no child that he does not know of.
    """
    program = _PROGRAM.format(
        owner=owner,
        apart=apart,
        package=__name__.partition(".")[0],
        folder=str(Path(__file__).parents[1]),
        module=module,
    )
    return [sys.executable, "-I", "-S", "-B", "-c", program, *words]
