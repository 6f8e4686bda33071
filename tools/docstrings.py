"""Check that every public docstring tells arguments, shapes and errors.

    python tools/docstrings.py               # the three packages; `make lint` runs this
    python tools/docstrings.py FILE...       # those files

numpydoc's own validation says which arguments are missing, unknown, out of order or without a
description. Three things it cannot see are seen here: fields of dataclasses, shapes of arrays, and
errors that a body raises. ``docs/docstrings.md`` states the rule. Files are parsed, never imported.
"""

import argparse
import ast
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from numpydoc.hooks.validate_docstrings import AstValidator
from numpydoc.validate import validate

ROOT = Path(__file__).parents[1]
PACKAGES = ("barrier_certificates", "rps_compat", "posflock_robotarium")
#: Modules, or folders of them, that the rule does not hold yet. Empty it; add nothing.
NOT_YET_HELD: frozenset[str] = frozenset()
#: What numpydoc checks; a type (PR04) and a Returns section (RT01) the annotations give already.
CODES = frozenset({"GL06", "GL07", "GL08", "SS01", "SS03", "SS06"}) | frozenset(
    {"PR01", "PR02", "PR03", "PR05", "PR07", "PR10", "RT03"}
)
#: Annotations that name an array, and what counts as its shape: ``(2, N) array``, ``(...) array``.
ARRAYS = re.compile(r"\b(\w*Array|NDArray|ndarray|ArrayLike)\b")
SHAPE = re.compile(r"\([^()]*\)[\w -]* arrays?\b|\([^()]*\) or \(")
#: A shape in the first lines of what takes no arguments: "Return the (2, N) positions, m."
SHAPE_IN_WORDS = re.compile(r"\((\.\.\.|[\w+*/ -]+,[\w+*/ ,.-]*)\)")
#: Methods that a base class outside of the project names and tells, and that only it calls.
CALLED_BY_A_BASE = re.compile(r"visit_\w+|generic_visit")
#: Bases whose subclasses' annotated names are fields.
FIELD_BASES = {"NamedTuple", "TypedDict"}
Function = ast.FunctionDef | ast.AsyncFunctionDef


@dataclass(frozen=True)
class Fault:
    """A docstring that leaves something out, or says something untrue."""

    path: Path
    line: int
    name: str
    text: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.name}: {self.text}"


def is_public(name: str) -> bool:
    """Return whether `name` has no leading underscore."""
    return not name.startswith("_")


def last_name(node: ast.expr) -> str:
    """Return ``c`` of ``a.b.c``, of a call of it, or of a subscript of it."""
    while isinstance(node, ast.Call | ast.Subscript):
        node = node.func if isinstance(node, ast.Call) else node.value
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


def decorators(node: Function | ast.ClassDef) -> list[str]:
    """Return the last names of the decorators of `node`, with ``x.setter`` as ``setter``."""
    return [last_name(decorator) for decorator in node.decorator_list]


def names_an_array(annotation: ast.expr | None) -> bool:
    """Return whether values of this type are, or hold, arrays; what a callable takes is its own."""
    if annotation is None or last_name(annotation) in ("Callable", "type"):
        return False
    return bool(ARRAYS.search(re.sub(r"Callable\[.*\]", "", ast.unparse(annotation))))


def raised(function: Function) -> Iterator[str]:
    """Yield the names of errors that `function` raises itself, not through what it calls."""
    waiting: list[ast.AST] = list(function.body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, Function | ast.ClassDef | ast.Lambda):
            continue
        if isinstance(node, ast.Raise) and node.exc is not None:
            name = last_name(node.exc)
            if re.fullmatch(r"[A-Z]\w*|Exit", name):
                yield name
        waiting.extend(ast.iter_child_nodes(node))


def fields(node: ast.ClassDef) -> dict[str, ast.expr]:
    """Return the public fields of a dataclass or a named tuple, with their annotations."""
    named = {last_name(base) for base in node.bases}
    if "dataclass" not in decorators(node) and not named & FIELD_BASES:
        return {}
    return {
        line.target.id: line.annotation
        for line in node.body
        if isinstance(line, ast.AnnAssign)
        and isinstance(line.target, ast.Name)
        and is_public(line.target.id)
        and last_name(line.annotation) not in ("KW_ONLY", "ClassVar")
    }


def arguments(function: Function) -> dict[str, ast.expr | None]:
    """Return the arguments with their annotations, in order, without self."""
    told = function.args
    found = {argument.arg: argument.annotation for argument in (*told.posonlyargs, *told.args)}
    if told.vararg:
        found["*" + told.vararg.arg] = told.vararg.annotation
    found |= {argument.arg: argument.annotation for argument in told.kwonlyargs}
    if told.kwarg:
        found["**" + told.kwarg.arg] = told.kwarg.annotation
    return {name: kind for name, kind in found.items() if name not in ("self", "cls")}


class Classes:
    """Every class of the project by name, to know what a class inherits."""

    def __init__(self, trees: list[ast.Module]) -> None:
        self._of_name = {
            node.name: node
            for tree in trees
            for node in ast.walk(tree)
            if isinstance(node, ast.ClassDef)
        }

    def bases(self, node: ast.ClassDef) -> Iterator[ast.ClassDef]:
        """Yield the classes of the project that `node` derives from, the nearest first."""
        for base in node.bases:
            found = self._of_name.get(last_name(base))
            if found is not None and found is not node:
                yield found
                yield from self.bases(found)

    def overridden(self, node: ast.ClassDef | None, method: str) -> Function | None:
        """Return the public method of a base that `method` of `node` stands for."""
        if node is None:
            return None
        for base in self.bases(node):
            for line in base.body:
                if isinstance(line, Function) and line.name == method and ast.get_docstring(line):
                    return line
        return None


class Checked(AstValidator):
    """numpydoc's view of one public definition, with fields as its parameters."""

    def __init__(
        self, node: Function | ast.ClassDef, path: Path, name: str, within: ast.AST, known: Classes
    ) -> None:
        super().__init__(ast_node=node, filename=path, obj_name=name, ancestry=[within])
        self._known = known

    @cached_property
    def constructor(self) -> Function | None:
        """The ``__init__`` of a class, or the ``__post_init__`` of a dataclass."""
        for line in self.node.body:
            if isinstance(line, Function) and line.name in ("__init__", "__post_init__"):
                return line
        return None

    @cached_property
    def annotations(self) -> dict[str, ast.expr | None]:
        """What has to be told, in order, with the annotation of each."""
        if not self.is_class:
            return arguments(self.node)
        if found := fields(self.node):
            return dict(found)
        starts = self.constructor
        return arguments(starts) if starts is not None and starts.name == "__init__" else {}

    @property
    def signature_parameters(self) -> tuple[str, ...]:
        """What has to be told, and at their places what may be: inherited fields, named options."""
        own, told = list(self.annotations), list(self.doc_all_parameters)
        optional: set[str] = set()
        if self.is_class:
            optional = {name for base in self._known.bases(self.node) for name in fields(base)}
        options = next((name for name in own if name.startswith("**")), None)
        if options is not None and options not in told:  # told by name instead
            optional |= set(told)
            own.remove(options)
        for place, name in enumerate(told):
            if name not in own and name in optional:
                own.insert(place, name)
        return tuple(own)

    @property
    def doc_all_parameters(self) -> dict[str, tuple[str, list[str]]]:
        """What is told: of a class with fields also under Attributes."""
        sections = ["Parameters", "Other Parameters"]
        if self.is_class and fields(self.node):
            sections.append("Attributes")
        told: dict[str, tuple[str, list[str]]] = self._doc_parameters(sections)
        return told

    def faults(self) -> Iterator[str]:
        """Yield what this docstring lacks."""
        for code, text in validate(self.name, lambda obj_name: self)["errors"]:
            if code in CODES:
                yield f"{code} {text}"
        if self.raw_doc:
            yield from self._shapes()
            yield from self._errors()

    def _shapes(self) -> Iterator[str]:
        for name, annotation in self.annotations.items():
            kind = self.doc_all_parameters.get(name, ("(...) array", []))[0]
            if names_an_array(annotation) and not SHAPE.search(kind):
                yield f"shape of {name} is missing: `{name} : (3, N) array`"
        if self.is_class or not names_an_array(self.node.returns):
            return
        told = [entry.type for entry in (*self.returns, *self.yields)]
        told = told or ([] if self.annotations else [self.summary, self.extended_summary])
        pattern = SHAPE if self.returns or self.yields else SHAPE_IN_WORDS
        if not any(pattern.search(text) for text in told):
            yield "shape of what is returned is missing: Returns, `(3, N) array`"

    def _errors(self) -> Iterator[str]:
        body = self.constructor if self.is_class else self.node
        told = {
            name.rpartition(".")[2]
            for entry in self.doc["Raises"]
            for name in re.split(r",\s*|\s+or\s+", entry.type or entry.name)
        }
        for name in sorted(set(raised(body)) - told if body is not None else ()):
            yield f"{name} is raised but not under Raises"


def definitions(tree: ast.Module) -> Iterator[tuple[Function | ast.ClassDef, ast.AST, str]]:
    """Yield every public function, method and class, what it lies in, and its dotted name."""
    waiting: list[tuple[ast.AST, str]] = [(tree, "")]
    while waiting:
        within, prefix = waiting.pop()
        for node in within.body:
            if isinstance(node, Function | ast.ClassDef) and _counts(node, within):
                yield node, within, prefix + node.name
                if isinstance(node, ast.ClassDef):
                    waiting.append((node, f"{prefix}{node.name}."))


def _counts(node: Function | ast.ClassDef, within: ast.AST) -> bool:
    if set(decorators(node)) & {"setter", "deleter", "overload", "command", "callback"}:
        return False
    in_class = isinstance(within, ast.ClassDef)
    return is_public(node.name) and not (in_class and CALLED_BY_A_BASE.fullmatch(node.name))


def commands(root: Path) -> set[str]:
    """Return the functions that the command line registers: their options tell themselves."""
    text = (root / "posflock_robotarium" / "cli.py").read_text("utf-8")
    return set(re.findall(r"\b(?:%s)\.\w+(?=[,)])" % "bundle|calibrate|paper|report|run|sweep|verify", text))


def held(path: Path) -> bool:
    """Return whether the rule holds for the file at `path`, relative to the project."""
    parts = path.with_suffix("").parts
    if not all(is_public(part) or part == "__init__" for part in parts):
        return False
    return not any("/".join(parts[:length]) in NOT_YET_HELD for length in range(1, len(parts) + 1))


def check(paths: list[Path], root: Path = ROOT) -> list[Fault]:
    """Return the faults of the files at `paths`, in order."""
    trees = {path: ast.parse(path.read_text("utf-8")) for path in paths}
    project = [ast.parse(p.read_text("utf-8")) for name in PACKAGES for p in (root / name).rglob("*.py")]
    known = Classes([*project, *trees.values()])
    registered = commands(root) 
    found = []
    for path, tree in trees.items():
        for node, within, name in definitions(tree):
            if path.parent.name == "commands" and f"{path.stem}.{name}" in registered:
                continue
            base = known.overridden(within if isinstance(within, ast.ClassDef) else None, node.name)
            checked = Checked(node, path, name, within, known)
            for text in checked.faults():
                if base is not None and not checked.doc["Parameters"] and text.startswith(("PR01", "shape")):
                    continue
                found.append(Fault(path, node.lineno, name, text))
    return found


def main() -> int:
    """Print every fault; return 1 where there is one."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("files", nargs="*", type=Path)
    files = asked.parse_args().files or sorted(
        path
        for name in PACKAGES
        for path in (ROOT / name).rglob("*.py")
        if held(path.relative_to(ROOT))
    )
    faults = check(files)
    print(*faults, sep="\n")
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
