"""Which names a function binds: as Python's own symbol table has it."""

import ast
import symtable
import sysconfig
from pathlib import Path

import pytest

from rps_compat.scripts.scopes import names_of

STANDARD = Path(sysconfig.get_path("stdlib"))
SOURCES = [
    *sorted(Path(__file__).parents[1].glob("rps_compat/**/*.py"))[::6],
    *(STANDARD / f"{name}.py" for name in ("argparse", "dataclasses", "inspect", "tarfile")),
]


def functions_of(table):
    """All functions in a table: (name, line) → its names, as Python has them."""
    found = {}
    for child in table.get_children():
        if child.get_type() == "function":
            own = {n for n in child.get_locals() if not n.startswith(".")}
            found.setdefault((child.get_name(), child.get_lineno()), []).append(
                (own, set(child.get_globals()), set(child.get_nonlocals()))
            )
        found |= functions_of(child)
    return found


def targets_within(function):
    """Targets of comprehensions: from Python 3.12 on they are the function's own as well."""
    return {
        name.id
        for node in ast.walk(function)
        if isinstance(node, ast.comprehension)
        for name in ast.walk(node.target)
        if isinstance(name, ast.Name)
    }


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.stem)
def test_names_of_functions_are_those_of_pythons_symbol_table(path):
    text = path.read_text(encoding="utf-8")
    there = functions_of(symtable.symtable(text, str(path), "exec"))
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            continue
        line = min([node.lineno, *(d.lineno for d in node.decorator_list)])
        tables = there.get((node.name, node.lineno)) or there[node.name, line]
        names = names_of(node)
        assert any(
            names.local == own - (targets_within(node) - names.local)
            and names.taken_global <= its_global
            and names.taken_nonlocal <= its_nonlocal
            for own, its_global, its_nonlocal in tables
        ), (node.name, names.local ^ tables[0][0])


@pytest.mark.parametrize(
    ("body", "local"),
    [
        ("a = b = 1; c: int = 2; d += 1", "abcd"),
        ("(a, [b, *c]), d.e, f[0] = x", "abc"),
        ("for a, b in x:\n  pass\nelse:\n  c = 1", "abc"),
        ("with x as (a, b), y as c:\n  pass", "abc"),
        ("try:\n  pass\nexcept E as a:\n  pass", "a"),
        ("[a for a in x if (b := a)]", "b"),
        ("{a: (c := b) for a in x for b in y}", "c"),
        ("lambda a: (b := a)", ""),
        ("def a(b=(c := 1)):\n  d = 1", "ac"),
        ("class a(b):\n  c = 1", "a"),
        ("import a.b, c as d\nfrom e import f, g as h", "adfh"),
        ("match x:\n  case [a, *b]: pass\n  case {'k': c, **d}: pass", "abcd"),
        ("match x:\n  case P(a) | Q(a) as b: pass", "ab"),
        ("del a", "a"),
        ("global a\na = b = 1", "b"),
        ("if (a := x) or (b := y):\n  pass", "ab"),
    ],
)  # fmt: skip
def test_every_way_to_bind_a_name(body, local):
    text = "def f():\n" + "".join(f"  {line}\n" for line in body.split("\n"))
    (function,) = ast.parse(text).body
    assert names_of(function).local == set(local)
    (table,) = symtable.symtable(text, "", "exec").get_children()
    own = {name for name in table.get_locals() if not name.startswith(".")}
    assert own - (targets_within(function) - set(local)) == set(local)
