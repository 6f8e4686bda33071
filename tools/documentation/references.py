"""Names in docstrings and signatures lead to their entries, by whichever path they are told.

Annotations name a class by where it is defined, which may be a private module behind a public one;
prose in single backticks names it as its reader knows it, and arguments in the same way. What leads
nowhere stays text.
"""

from __future__ import annotations

import contextlib
import importlib
import re
from collections import Counter
from typing import get_origin

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.nodes import make_refnode
from sphinx.util.typing import ExtensionMetadata

from tools.documentation.api_pages import FOLDER
from tools.documentation.public_names import PACKAGES, PublicSurface, public_surface


class Entries:
    """Where the entry of a name or module is, by any of its paths.

    Parameters
    ----------
    surface : PublicSurface
        What is public.
    """

    def __init__(self, surface: PublicSurface) -> None:
        self._entries = {module: module for module in surface.modules}
        for name in surface.names:
            entry = surface.entries[name.path]
            self._entries |= {name.path: entry, name.origin: entry}
        last = Counter(path.rpartition(".")[2] for path in set(self._entries.values()))
        self._unique = {
            path.rpartition(".")[2]: path
            for path in self._entries.values()
            if last[path.rpartition(".")[2]] == 1
        }
        self._modules = set(surface.modules)

    def find(self, target: str, module: str | None) -> tuple[str, str] | None:
        """Return the page of an entry below the root of the site, and its anchor.

        Parameters
        ----------
        target : str
            The name as it is told.
        module : str, optional
            Where it is told; a name means what it means there.
        """
        module = module or ""
        parts = module.split(".") if module else []
        nearer = [".".join([*parts[:n], target]) for n in range(len(parts), -1, -1)]
        for path in nearer:
            if path in self._entries:
                return self._place(self._entries[path])
        return self._place(self._unique[target]) if target in self._unique else None

    def _place(self, entry: str) -> tuple[str, str]:
        module = entry if entry in self._modules else entry.rpartition(".")[0]
        return f"{FOLDER}/{module}", f"module-{entry}" if entry in self._modules else entry


def setup(app: Sphinx) -> ExtensionMetadata:
    """Have Sphinx ask here where it does not find a name itself.

    Parameters
    ----------
    app : Sphinx
        The build.
    """
    entries = Entries(public_surface())

    def resolve(
        app: Sphinx, env: BuildEnvironment, node: pending_xref, content: nodes.TextElement
    ) -> nodes.Node | None:
        if node.get("refdomain") != "py":
            return None
        target = str(node["reftarget"])
        found = entries.find(target.removeprefix("~").lstrip("."), node.get("py:module"))
        if found is not None:
            return make_refnode(app.builder, node["refdoc"], *found, content)
        # Annotations name types of other libraries, backticks in prose name arguments, and a class
        # may have a private base. Those stay text; what is told in full has to be there.
        in_annotation = "refwarn" not in node
        plain = in_annotation or node.get("reftype") == "obj" or _is_there(target)
        return content if plain else None

    app.connect("missing-reference", resolve)
    app.connect("autodoc-process-docstring", _keep_bars)
    app.connect("autodoc-process-signature", _name_arrays)
    app.connect("autodoc-process-bases", _without_types)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _is_there(path: str) -> bool:
    """Return whether a dotted path leads to a module or an object of the project."""
    if path.partition(".")[0] not in PACKAGES:
        return False
    with contextlib.suppress(ImportError):
        return bool(importlib.import_module(path))
    module, _, name = path.rpartition(".")
    with contextlib.suppress(ImportError):
        return hasattr(importlib.import_module(module), name)
    return False


def _without_types(
    app: Sphinx, name: str, obj: object, options: object, bases: list[object]
) -> None:
    """Name the classes that one is made from, without what they are told to hold."""
    bases[:] = [get_origin(base) or base for base in bases]


#: Literals, in which nothing is special, and the bars of absolute values.
_LITERAL_OR_BAR = re.compile(r"``.*?``|`[^`]*`|\|")
#: Types of numpy's as Python tells them, and as they are written.
_ARRAYS = (
    (
        re.compile(r"~?numpy\.ndarray\[tuple\[[^]]*\], ~?numpy\.dtype\[~?numpy\.(\w+)\]\]"),
        r"NDArray[\1]",
    ),
    (re.compile(r"~?numpy\._typing\.\S*_Buffer \| .*?\| str \| bytes\]"), "ArrayLike"),
)


def _keep_bars(
    app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]
) -> None:
    """Let ``|v|`` be an absolute value: docstrings have no substitutions, which it would be."""
    lines[:] = [
        _LITERAL_OR_BAR.sub(lambda found: r"\|" if found[0] == "|" else found[0], line)
        for line in lines
    ]


def _name_arrays(
    app: Sphinx,
    what: str,
    name: str,
    obj: object,
    options: object,
    told: str | None,
    returned: str | None,
) -> tuple[str | None, str | None]:
    """Call arrays in signatures what they are called in the code."""
    for pattern, short in _ARRAYS:
        told = told and pattern.sub(short, told)
        returned = returned and pattern.sub(short, returned)
    return told, returned
