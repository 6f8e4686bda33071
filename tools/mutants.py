"""Mutation testing: change the code in one place, and see whether its tests notice.

    python tools/mutants.py                          # every module below, every mutant: takes hours
    python tools/mutants.py --sample 40 --seed 1     # 40 mutants of each
    python tools/mutants.py law judge --sample 100

A mutant that no test kills is a fault that no test would find. Each module of `TARGETS` names the
test files that are to kill its mutants; a mutant costs them once, up to the first failure.
Survivors are printed, and the exit code is 1 where over 10 % of a module's mutants survive. Those
that change nothing that anyone could see are listed in `equivalent_mutants.py`, with the reasons.

The changes themselves, and what is left alone, are in `mutations.py`. Nothing is written: a mutant
is compiled from the changed syntax tree, in a process of its own that imports it instead of the
file. So tests that start another Python see no mutant there, and kill it by what they see here.

Why not a known tool: mutmut 3 changes only what is inside functions, so that tables of names have
no mutants at all, and it has one selection of tests for all modules. cosmic-ray changes neither
strings nor the arguments of calls; most of its arithmetic (``>>`` of floats) fails on any call and
says nothing of the tests; and it starts a Python for every mutant. Neither takes samples.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import importlib.abc
import importlib.util
import os
import random
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

from equivalent_mutants import EQUIVALENT
from mutations import mutations

ROOT = Path(__file__).resolve().parents[1]
MOST_SURVIVORS = 0.10
#: Imported once, not for every mutant.
PRELOADED = ("hypothesis", "matplotlib.pyplot", "numpy", "pytest", "scipy.signal")


@dataclass(frozen=True)
class Target:
    """Modules by patterns, and the test files that are to kill their mutants, quickest first."""

    modules: tuple[str, ...]
    tests: tuple[str, ...]


TARGETS = {
    "law": Target(("posflock_robotarium/flocking/law.py",), ("test_law",)),
    "flock": Target(
        ("posflock_robotarium/flocking/flock.py",), ("test_flock_step", "test_flock_ties")
    ),
    "steering": Target(("posflock_robotarium/flocking/steering.py",), ("test_steering",)),
    "projection": Target(
        ("barrier_certificates/projection/*.py",),
        ("test_barrier_relaxed", "test_barrier_projection", "test_barrier_large_numbers"),
    ),
    "links": Target(
        (
            "barrier_certificates/rows/links.py",
            "barrier_certificates/rows/kept_links.py",
            "barrier_certificates/rows/linked_book.py",
        ),
        ("test_kept_links", "test_barrier_connectivity"),
    ),
    "arena": Target(
        ("rps_compat/arena.py", "rps_compat/arena_guests.py", "rps_compat/violations.py"),
        ("test_arena_edges", "test_arena", "test_robotarium_faces"),
    ),
    "numbers": Target(
        (
            "posflock_robotarium/alignment/catalogue/*.py",
            "posflock_robotarium/alignment/measured_run.py",
        ),
        (
            "test_metric_catalogue",
            "test_numbers_by_hand",
            "test_measured_run",
            "test_numbers",
            "test_metric_registry",
            "test_shapes_by_hand",
            "test_questions",
            "test_real_time",
            "test_following",
            "test_gaps",
        ),
    ),
    "judge": Target(("posflock_robotarium/verify/judge.py",), ("test_judge",)),
    "tables": Target(
        (
            "rps_compat/scripts/changes.py",
            "rps_compat/scripts/generation_names.py",
            "rps_compat/scripts/libraries.py",
            "rps_compat/scripts/*_names.py",
        ),
        ("test_name_tables",),
    ),
}


@dataclass(frozen=True)
class Mutant:
    """The change number `index` of a file, and what it is."""

    file: str
    index: int
    line: int
    source: str
    change: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.change}   {self.source}"

    @property
    def is_equivalent(self) -> bool:
        """Whether it is listed as one that changes nothing."""
        return any(
            file in self.file and source in self.source and change in self.change
            for file, source, change, _ in EQUIVALENT
        )


def mutants_of(target: Target) -> list[Mutant]:
    """Return all mutants of a target's modules."""
    found = []
    for path in sorted({path for pattern in target.modules for path in ROOT.glob(pattern)}):
        text = path.read_text(encoding="utf-8")
        lines = text.splitlines()
        for index, change in enumerate(mutations(ast.parse(text))):
            source = lines[change.line - 1].strip()
            file = path.relative_to(ROOT).as_posix()
            found.append(Mutant(file, index, change.line, source, change.what))
    return found


class _MutantImporter(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Imports one mutated module, and leaves all others to Python."""

    def __init__(self, mutant: Mutant) -> None:
        self.path = ROOT / mutant.file
        parts = Path(mutant.file).with_suffix("").parts
        self.name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        tree = ast.parse(self.path.read_text(encoding="utf-8"))
        list(mutations(tree))[mutant.index].apply()
        self.code = compile(ast.fix_missing_locations(tree), str(self.path), "exec")

    def find_spec(self, name: str, path: object, target: object = None) -> ModuleSpec | None:
        if name != self.name:
            return None
        return importlib.util.spec_from_file_location(name, self.path, loader=self)

    def create_module(self, spec: ModuleSpec) -> None:
        return None

    def exec_module(self, module: ModuleType) -> None:
        exec(self.code, module.__dict__)

    def get_filename(self, name: str) -> str:
        return str(self.path)

    def is_package(self, name: str) -> bool:
        return self.path.name == "__init__.py"


def run_tests(tests: Sequence[str], mutant: Mutant | None, seconds: float) -> str:
    """Run test files in a process of their own: "passed", "failed", or "too long"."""
    child = os.fork()
    if child == 0:
        os.setsid()
        code = 3
        try:
            import pytest

            silence = os.open(os.devnull, os.O_WRONLY)
            os.dup2(silence, 1)
            os.dup2(silence, 2)
            if mutant is not None:
                sys.meta_path.insert(0, _MutantImporter(mutant))
            options = ["-q", "-x", "-p", "no:cacheprovider", "--tb=no"]
            options += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]  # hypothesis is there
            code = pytest.main([*options, *(f"tests/{name}.py" for name in tests)])
        finally:
            os._exit(int(code))
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return "passed" if status == 0 else "failed"
        time.sleep(0.01)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return "too long"


def survivors_of(target: Target, chosen: Sequence[Mutant]) -> Iterator[Mutant]:
    """Yield the mutants that all tests of a target pass."""
    begun = time.monotonic()
    if run_tests(target.tests, None, 600.0) != "passed":
        raise SystemExit(f"{', '.join(target.tests)}: do not pass without any mutant")
    seconds = 10.0 + 4.0 * (time.monotonic() - begun)
    for mutant in chosen:
        if run_tests(target.tests, mutant, seconds) == "passed":
            yield mutant


def main() -> int:
    """Run the mutants that were asked for, and return the exit code."""
    parser = argparse.ArgumentParser(description="Mutation testing.")
    parser.add_argument("targets", nargs="*", metavar="module", help=", ".join(TARGETS))
    parser.add_argument("--sample", type=int, help="so many mutants of each module, not all")
    parser.add_argument("--seed", type=int, default=0, help="of the sample")
    parser.add_argument("--list", action="store_true", help="list the mutants and run none")
    options = parser.parse_args()
    if unknown := set(options.targets) - TARGETS.keys():
        parser.error(f"no module is called {', '.join(unknown)}; there are {', '.join(TARGETS)}")
    os.chdir(ROOT)
    sys.path.insert(0, str(ROOT))
    for library in PRELOADED:
        importlib.import_module(library)
    failed = False
    for name in options.targets or TARGETS:
        found = mutants_of(TARGETS[name])
        real = [mutant for mutant in found if not mutant.is_equivalent]
        chosen = real
        if options.sample is not None and options.sample < len(real):
            chosen = random.Random(options.seed).sample(real, options.sample)
        if options.list:
            print(*(f"{mutant}{' =' * mutant.is_equivalent}" for mutant in found), sep="\n")
            continue
        count = 0
        for mutant in survivors_of(TARGETS[name], chosen):
            count += 1
            print(f"  survived  {mutant}", flush=True)
        share = count / max(1, len(chosen))
        print(
            f"{name}: {count} of {len(chosen)} mutants survived, {share:.1%}"
            f" (of {len(found)}, {len(found) - len(real)} equivalent)",
            flush=True,
        )
        failed |= share > MOST_SURVIVORS
    return int(failed)


if __name__ == "__main__":
    raise SystemExit(main())
