"""Check that every public docstring tells arguments, shapes and errors.

    python tools/docstrings.py               # the three packages; `make lint` runs this
    python tools/docstrings.py FILE...       # those files

numpydoc's own validation says which arguments are missing, unknown, out of order or without a
description. Three things it cannot see are seen here: fields of dataclasses, shapes of arrays, and
errors that a body raises. What a method inherits from the method that it overrides need not be told
again. ``CONTRIBUTING.md`` states the rule. Files are parsed, never imported.
"""

import argparse
import ast
import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from numpydoc.hooks.validate_docstrings import AstValidator
from numpydoc.validate import validate

ROOT = Path(__file__).parents[1]
PACKAGES = ("barrier_certificates", "rps_compat", "posflock_robotarium")
#: What numpydoc checks. Types (PR04) and what is returned (RT01) are in the annotations already.
CODES = frozenset(
    "GL06 GL07 GL08 SS01 SS03 SS06 PR01 PR02 PR03 PR05 PR07 PR10 RT03".split()  # noqa: SIM905
)
_SHAPE = r"\((?:\.\.\.|[^()]*,[^()]*)\)"
#: A shape in a type: ``(2, N) array``, ``(N,) boolean array``, ``dict of (...) arrays``.
SHAPE_IN_TYPE = re.compile(_SHAPE + r"[\w -]* arrays?\b")
#: A shape in the words of what takes no arguments: "Return the (2, N) positions, m."
SHAPE_IN_WORDS = re.compile(_SHAPE)
#: Descriptions that only say the name again.
FILLER = re.compile(r"(The|Its|Their) \w+\.")
#: Methods that a base class outside of the project names and tells, and that only it calls.
CALLED_BY_A_BASE = re.compile(r"visit_\w+|generic_visit")
#: Bases whose subclasses' annotated names are fields.
FIELD_BASES = {"NamedTuple", "TypedDict"}
Function = ast.FunctionDef | ast.AsyncFunctionDef
Definition = Function | ast.ClassDef


@dataclass(frozen=True)
class Fault:
    """What a docstring leaves out, or says that is not so."""

    path: Path
    line: int
    name: str
    text: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.name}: {self.text}"


def last_name(node: ast.expr) -> str:
    """Return ``c`` of ``a.b.c``, of a call of it, or of a subscript of it."""
    while isinstance(node, ast.Call | ast.Subscript):
        node = node.func if isinstance(node, ast.Call) else node.value
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


def is_array_type(node: ast.expr) -> bool:
    """Return whether an expression is ``NDArray``, ``np.ndarray`` or a subscript of them."""
    return not isinstance(node, ast.Call) and last_name(node) in ("NDArray", "ndarray")


def decorators(node: Definition) -> set[str]:
    """Return the last names of the decorators: ``setter`` of ``x.setter``."""
    return {last_name(decorator) for decorator in node.decorator_list}


def raised(function: Function) -> Iterator[str]:
    """Yield the names of errors that a function raises itself, not through what it calls."""
    waiting: list[ast.AST] = list(function.body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, Function | ast.ClassDef | ast.Lambda):
            continue
        if isinstance(node, ast.Raise) and node.exc is not None:
            name = last_name(node.exc)
            if name[:1].isupper():  # else a helper or a variable, whose class the text hides
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
        and not line.target.id.startswith("_")
        and last_name(line.annotation) not in ("KW_ONLY", "ClassVar")
    }


def arguments(function: Function) -> dict[str, ast.expr | None]:
    """Return the arguments with their annotations, in order, without self."""
    of = function.args
    found = {argument.arg: argument.annotation for argument in (*of.posonlyargs, *of.args)}
    if of.vararg:
        found["*" + of.vararg.arg] = of.vararg.annotation
    found |= {argument.arg: argument.annotation for argument in of.kwonlyargs}
    if of.kwarg:
        found["**" + of.kwarg.arg] = of.kwarg.annotation
    return {name: kind for name, kind in found.items() if name not in ("self", "cls")}


def is_command(node: Definition) -> bool:
    """Return whether the command line's options tell a function's arguments, in annotations."""
    return isinstance(node, Function) and bool(
        re.search(r"\btyper\.(Option|Argument)\(|: options\.[A-Z]", ast.unparse(node.args))
    )


class Project:
    """What has to be known of all files to judge one: array types, and what classes inherit."""

    def __init__(self, trees: Iterable[ast.Module]) -> None:
        self._classes: dict[str, list[ast.ClassDef]] = {}
        arrays = {"NDArray", "ndarray", "ArrayLike"}
        for node in (node for tree in trees for node in ast.walk(tree)):
            if isinstance(node, ast.ClassDef):
                self._classes.setdefault(node.name, []).append(node)
            elif isinstance(node, ast.Assign) and is_array_type(node.value):
                arrays |= {target.id for target in node.targets if isinstance(target, ast.Name)}
        self._arrays = re.compile(rf"\b({'|'.join(sorted(arrays))})\b")

    def inherited(self, node: ast.ClassDef) -> set[str]:
        """Return the names of the fields that a class has from others of the project."""
        return {name for base in self._bases(node) for name in fields(base)}

    def overridden(self, name: str, within: ast.AST) -> tuple[Function, ast.ClassDef] | None:
        """Return the documented method that one of this name overrides in a class, and its class.

        Only bases count that the class names: a Protocol, too, is one only where it says so.
        """
        for base in self._bases(within) if isinstance(within, ast.ClassDef) else ():
            for line in base.body:
                if isinstance(line, Function) and line.name == name and ast.get_docstring(line):
                    return line, base
        return None

    def _bases(self, node: ast.ClassDef, seen: frozenset[int] = frozenset()) -> list[ast.ClassDef]:
        """Return the classes of the project above one; of two with one name, both."""
        seen |= {id(node)}
        found: list[ast.ClassDef] = []
        for base in node.bases:
            for above in self._classes.get(last_name(base), ()):
                if id(above) not in seen:
                    found += [above, *self._bases(above, seen)]
        return found

    def names_an_array(self, annotation: ast.expr | None) -> bool:
        """Return whether values of this type are or hold arrays; a callable's are its own."""
        if annotation is None or last_name(annotation) in ("Callable", "type"):
            return False
        text = re.sub(r"Callable\[.*\]", "", ast.unparse(annotation))
        return self._arrays.search(text) is not None


class Checked(AstValidator):  # type: ignore[misc]
    """numpydoc's view of one public definition, with fields as its parameters."""

    def __init__(
        self, node: Definition, path: Path, name: str, within: ast.AST, project: Project
    ) -> None:
        super().__init__(ast_node=node, filename=path, obj_name=name, ancestry=[within])
        self._path, self._within, self._project = path, within, project

    @cached_property
    def above(self) -> "Checked | None":
        """The documented method that this one overrides, which tells what this does not."""
        found = None if self.is_class else self._project.overridden(self.node.name, self._within)
        if found is None:
            return None
        return Checked(found[0], self._path, self.name, found[1], self._project)

    @cached_property
    def inherited(self) -> set[str]:
        """The parameters that need not be told again."""
        if self.is_class:
            return self._project.inherited(self.node)
        if self.above is None:
            return set()
        return self.annotations.keys() & (self.above.annotations.keys() | self.above.inherited)

    @cached_property
    def errors(self) -> set[str]:
        """The last names of the errors that are told, here or above."""
        told = {
            name.rpartition(".")[2]
            for entry in self.doc["Raises"]
            for name in re.split(r",\s*", entry.type or entry.name)
        }
        return told if self.above is None else told | self.above.errors

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
        """What has to be told, and at their places what may be: the inherited, named options."""
        told, optional = list(self.doc_all_parameters), self.inherited
        own = [name for name in self.annotations if self.is_class or name not in optional]
        options = next((name for name in own if name.startswith("**")), None)
        if options is not None and options not in told and set(told) - set(own):
            optional = optional | set(told)  # each by its name instead
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

    #: Asked by numpydoc for RT01, which is not checked, and costs another parsing of the file.
    method_returns_something = False

    def faults(self) -> Iterator[str]:
        """Yield what this docstring lacks."""
        for code, text in validate(self.name, validator_cls=lambda obj_name: self)["errors"]:
            needless = code == "GL08" and self.above and not self.signature_parameters
            if code in CODES and not needless:  # GL08: there is no docstring
                yield f"{code} {text}"
        if self.raw_doc or self.above:
            for name, (_, text) in self.doc_all_parameters.items():
                if FILLER.fullmatch(" ".join(text)):
                    yield f"the description of {name} says nothing: {' '.join(text)!r}"
            yield from self._shapes()
            yield from self._errors()

    def _shapes(self) -> Iterator[str]:
        told = self.doc_all_parameters
        for name, annotation in self.annotations.items():
            if name not in told or not self._project.names_an_array(annotation):
                continue
            if not SHAPE_IN_TYPE.search(told[name][0]):
                yield f"the shape of {name} is missing, as in `{name} : (3, N) array`"
        if self.is_class or not self._project.names_an_array(self.node.returns):
            return
        types = [entry.type for entry in (*self.returns, *self.yields)]
        words = f"{self.summary} {self.extended_summary}"
        above = self.above
        if not types and above is not None and self._project.names_an_array(above.node.returns):
            return
        if any(SHAPE_IN_TYPE.search(text) for text in types):
            return
        if types or self.annotations or not SHAPE_IN_WORDS.search(words):
            yield "the shape of what is returned is missing: Returns, `(3, N) array`"

    def _errors(self) -> Iterator[str]:
        body = self.constructor if self.is_class else self.node
        for name in sorted(set(raised(body)) - self.errors if body is not None else ()):
            yield f"{name} is raised, but is not under Raises"


def definitions(tree: ast.Module) -> Iterator[tuple[Definition, ast.AST, str]]:
    """Yield every public function, method and class, what it lies in, and its dotted name."""
    waiting: list[tuple[ast.Module | ast.ClassDef, str]] = [(tree, "")]
    while waiting:
        within, prefix = waiting.pop()
        for node in within.body:
            if isinstance(node, Definition) and _counts(node, within):
                yield node, within, prefix + node.name
                if isinstance(node, ast.ClassDef):
                    waiting.append((node, f"{prefix}{node.name}."))


def _counts(node: Definition, within: ast.AST) -> bool:
    if is_command(node) or decorators(node) & {"setter", "deleter", "overload"}:
        return False
    if isinstance(within, ast.ClassDef) and CALLED_BY_A_BASE.fullmatch(node.name):
        return False
    return node.name == "__call__" or not node.name.startswith("_")


def is_public(path: Path) -> bool:
    """Return whether no part of a module's path, relative to the project, has an underscore."""
    return not any(
        part.startswith("_") and part != "__init__" for part in path.with_suffix("").parts
    )


def check(paths: Iterable[Path], root: Path = ROOT) -> list[Fault]:
    """Return the faults of the files at `paths`, of the project in `root`, by file and line."""
    trees = {path: ast.parse(path.read_text("utf-8")) for path in paths}
    others = {path for name in PACKAGES for path in (root / name).rglob("*.py")} - trees.keys()
    project = Project([*trees.values(), *(ast.parse(p.read_text("utf-8")) for p in others)])
    found = [
        Fault(path, node.lineno, name, text)
        for path, tree in trees.items()
        for node, within, name in definitions(tree)
        for text in Checked(node, path, name, within, project).faults()
    ]
    return sorted(found, key=lambda fault: (fault.path, fault.line))


def main() -> int:
    """Print every fault; return 1 where there is one."""
    asked = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    asked.add_argument("files", nargs="*", type=Path)
    everything = (path for name in PACKAGES for path in sorted((ROOT / name).rglob("*.py")))
    faults = check(
        asked.parse_args().files or [p for p in everything if is_public(p.relative_to(ROOT))]
    )
    for fault in faults:
        print(fault)
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
