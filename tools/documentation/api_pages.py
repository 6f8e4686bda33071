"""The API reference: a page for each public module, with an entry for each of its names.

Everything on these pages is read from the docstrings. Which modules and names there are is decided
by `public_names`, so that a name that is made public has its entry without further work.
"""

from __future__ import annotations

import enum
import re

from tools.documentation.public_names import PACKAGES, PublicName, PublicSurface

#: Where the pages stand, below the root of the site.
FOLDER = "reference/api"
#: Longer values of constants are left to the source.
LONGEST_VALUE = 200

_INDEX = """\
API reference
=============

Public is what is listed here, and nothing else: what ``__all__`` leads to from the three packages.
A package lists its public modules there, a module its public names; a public module without
``__all__`` means its functions, classes and constants without a leading underscore. Any other
module, and any name with a leading underscore, may change or go without notice. What of these a
major version keeps for certain stands in :doc:`what 1.x keeps </reference/public-surface>`.

Scripts import the Robotarium's own API, ``rps``, which stands for `rps_compat.v1` or
`rps_compat.v2`, whichever generation they were written for.

{contents}"""

_PAGE = """\
{underlined}

.. automodule:: {path}
   :no-members:
{names}{contents}
{entries}"""


def api_pages(surface: PublicSurface) -> dict[str, str]:
    """Return the text of every page, by its path below the root of the site.

    Parameters
    ----------
    surface : PublicSurface
        What is public.
    """
    pages = {f"{FOLDER}/index.rst": _INDEX.format(contents=_contents(list(PACKAGES), ""))}
    for path in surface.modules:
        own = sorted(
            (name for name in surface.documented.values() if name.module == path),
            key=lambda name: (name.kind not in ("class", "exception"), name.name),
        )
        pages[f"{FOLDER}/{path}.rst"] = _PAGE.format(
            underlined=f"{path}\n{'=' * len(path)}",
            path=path,
            names=_names(path, own, surface),
            contents=_contents(surface.children(path), path),
            entries="\n".join(_entry(name) for name in own),
        )
    return pages


def _contents(paths: list[str], above: str) -> str:
    """Return a list of pages: each by its name within what is above it."""
    if not paths:
        return ""
    lines = [f"   {path.removeprefix(f'{above}.')} <{path}>" for path in paths]
    return "\n.. toctree::\n   :maxdepth: 1\n\n" + "\n".join(lines) + "\n"


def _names(path: str, own: list[PublicName], surface: PublicSurface) -> str:
    """Return what is on a page in a line, and which names have their entries on others."""
    elsewhere = [
        f":py:obj:`{name.name} <{surface.entries[name.path]}>`"
        for name in surface.names
        if name.module == path and surface.entries[name.path] != name.path
    ]
    here = [f":py:obj:`{name.name} <{name.path}>`" for name in own]
    told = f"\nNames: {', '.join(here)}.\n" if len(here) > 1 else ""
    return told + (f"\nFrom here, too: {', '.join(elsewhere)}.\n" if elsewhere else "")


def _entry(name: PublicName) -> str:
    if name.kind == "type":
        told = re.sub(r"\b(?:[a-z_]\w*\.)+(?=\w)", "", str(name.value))
        return f".. py:type:: {name.name}\n   :module: {name.module}\n   :canonical: {told}\n"
    lines = [f".. auto{name.kind}:: {name.path}"]
    if name.kind in ("class", "exception"):
        lines += ["   :members:"]
        if isinstance(name.value, type) and name.value.__bases__ != (object,):
            lines += ["   :show-inheritance:"]
        if isinstance(name.value, type) and issubclass(name.value, enum.Enum):
            lines += ["   :undoc-members:"]
    elif name.kind == "data" and len(repr(name.value)) > LONGEST_VALUE:
        lines += ["   :no-value:"]
    return "\n".join(lines) + "\n"
