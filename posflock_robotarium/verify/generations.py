"""Names that belong to one generation of the Robotarium's API only.

Generation 1 is the API of the GRITSBot years; generation 2, of GTernal robots, has been the
testbed's since April 2026.  A script with a name of the other generation stops at that name,
after having waited for its turn.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

from rps_compat.generations import FUNCTIONS, NEW_FUNCTIONS
from rps_compat.wrong_generation import RENAMED

#: Functions of generation 1 → what generation 2 calls them ("" where it has none).
_OLD_UTILITIES = {old: new or "" for old, new in FUNCTIONS.items()}
#: Functions that generation 2 alone has → what generation 1 has instead ("" for none).
_NEW_UTILITIES = dict.fromkeys(NEW_FUNCTIONS, "") | {
    new: old for old, new in reversed(FUNCTIONS.items()) if new
}
#: Attributes of the Robotarium object that are called.
_METHODS = ("call_at_scripts_end", "debug")
#: The one among its attributes that nobody else has, whatever the name before the dot.
_UNMISTAKABLE = "call_at_scripts_end"
_NEW_ATTRIBUTES = {new: old for old, new in RENAMED.items()}


def wrong_names(tree: ast.Module, generation: int) -> Iterator[tuple[int, str, str]]:
    """Yield line, name and replacement of every name that `generation` does not know.

    A name asked for with ``hasattr`` or ``getattr`` anywhere in the script is one that the
    script is prepared to miss.
    """
    functions = _OLD_UTILITIES if generation == 2 else _NEW_UTILITIES
    attributes = RENAMED if generation == 2 else _NEW_ATTRIBUTES
    probed = _probed(tree)
    # Who asks for one of a pair of names knows the other one, too.
    probed |= {table[name] for name in probed for table in (functions, attributes) if name in table}
    probed |= {name for table in (functions, attributes) for name in table if table[name] in probed}
    instances = _instances(tree)
    fields = {_field(name) for name in instances} - {
        ""
    }  # self.arena in a class, team.arena outside
    own = {n.name for n in ast.walk(tree) if isinstance(n, (ast.FunctionDef, ast.ClassDef))}
    own |= {
        n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
    }
    imported: set[str] = set()
    starred = False
    for node in ast.walk(tree):
        if not isinstance(node, ast.ImportFrom) or not (node.module or "").startswith("rps"):
            continue
        for alias in node.names:
            imported.add(alias.asname or alias.name)
            starred |= alias.name == "*"
            if alias.name in functions and not _is_guarded(tree, node):
                yield node.lineno, alias.name, functions[alias.name]
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and starred:
            if node.id in functions and node.id not in imported | own | probed:
                yield node.lineno, node.id, functions[node.id]
        elif isinstance(node, ast.Attribute) and node.attr not in probed:
            on = ast.unparse(node.value)
            surely = node.attr == _UNMISTAKABLE and node.attr not in own
            if node.attr in attributes and (surely or on in instances or _field(on) in fields):
                call = "()" if node.attr in _METHODS else ""
                yield node.lineno, node.attr, attributes[node.attr] + call
            elif node.attr in functions and on.split(".")[0] in _modules(tree):
                yield node.lineno, node.attr, functions[node.attr]


def generation_of(tree: ast.Module) -> int | None:
    """Return the generation a script is written for, None where nothing tells or both do."""
    wrong = {g: bool(list(wrong_names(tree, g))) for g in (1, 2)}
    if wrong[1] == wrong[2]:
        return None
    return 2 if wrong[1] else 1


def _instances(tree: ast.Module) -> set[str]:
    """Names and attributes that a ``Robotarium(…)`` is bound to, also through parameters."""
    found: set[str] = set()
    classes = {"Robotarium"} | {
        alias.asname or alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if alias.name == "Robotarium"
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call):
            func = node.value.func
            name = func.attr if isinstance(func, ast.Attribute) else getattr(func, "id", "")
            if name in classes:
                found |= {ast.unparse(target) for target in node.targets}
        elif isinstance(node, ast.arg) and node.annotation is not None:
            kind = ast.unparse(node.annotation).strip("'")
            found |= {node.arg} if kind.rpartition(".")[2] in classes else set()
    return found


def _field(name: str) -> str:
    """Return the attribute that ends a dotted name, nothing of a plain one."""
    return name.rpartition(".")[2] if "." in name else ""


def _modules(tree: ast.Module) -> set[str]:
    """Names that stand for a module of rps."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] == "rps":
                    found.add(alias.asname or "rps")
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("rps"):
            found |= {alias.asname or alias.name for alias in node.names}
    return found


def _probed(tree: ast.Module) -> set[str]:
    """Names that the script looks for before it uses them."""
    return {
        node.args[1].value
        for node in ast.walk(tree)
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in ("hasattr", "getattr")
        and len(node.args) > 1
        and isinstance(node.args[1], ast.Constant)
        and isinstance(node.args[1].value, str)
    }


def _is_guarded(tree: ast.Module, node: ast.stmt) -> bool:
    """Whether the import stands in a ``try``, or in the handler of one."""
    return any(
        isinstance(outer, ast.Try) and node in set(ast.walk(outer)) for outer in ast.walk(tree)
    )
