"""Runs the tests as other machines would: their processors, their libraries, their Pythons.

    python .ci/portable.py [--quick] [--environment NAME] [pytest arguments]

A processor decides by what it can do how numpy, the C library and OpenBLAS compute, and so the last
bits of a sine, a power, a matrix product. What one can do less, the others imitate: here these
libraries are told, one after the other, to leave out what the processor at hand has. A setting that
changes no bit of any result here is not run, and that is said.

All tests run where most is left out, those that numbers can touch under every other setting, and
all of them once more in other environments (``numpy1``, ``testbed``, ``newest``), which are made
beside this one's where their Python is on this machine. ``--environment`` runs in that one alone,
``--quick`` only what numbers can touch, without the lesser settings and other environments.

Prints a table of setting and result, and ends with 1 if some test failed.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from posflock_robotarium.submission.interpreters import find_python
from rps_compat.scripts.libraries import LIBRARIES, PYTHON

ROOT = Path(__file__).resolve().parents[1]

#: The tests whose outcome a last bit could touch.
NUMBERS = (
    "ties", "flock_ties", "golden", "barrier_golden", "barrier_projection", "barrier_rows",
    "barrier_safety", "barrier_unsafe", "barrier_parameters", "rps_kinematics", "rps_controllers",
    "rps_certificates", "rps_certificates_optimal", "rps_graphs_and_places",
    "robotarium_faces", "arena", "realism", "law", "metrics", "flock", "freespace",
    "pose_filter", "placement", "poselog", "onboard", "report_estimators",
)  # fmt: skip

#: What OpenBLAS can be told to take a processor for, from the oldest on.
CORES = ("Prescott", "Nehalem", "Sandybridge", "Haswell", "Zen", "SkylakeX", "SapphireRapids")

#: Says of the Python that runs it how it computes.
PROBE = """
import hashlib, json, math, platform, sys, warnings
import numpy as np
import scipy.linalg.lapack as lapack
try:
    from numpy._core import _multiarray_umath as core
except ImportError:
    from numpy.core import _multiarray_umath as core
try:
    from threadpoolctl import threadpool_info
    blas = sorted({i["architecture"] for i in threadpool_info() if "architecture" in i})
except ImportError:
    blas = []
x, y = np.random.default_rng(0).uniform(-3.0, 3.0, (2, 20000))
a = x[:3600].reshape(60, 60)
results = [np.sin(x), np.cos(x), np.tanh(x), np.exp(x), np.arctan2(y, x), np.abs(x) ** y,
           a @ a, a @ y[:60], np.array([x.dot(y), x.sum()]),
           lapack.dposv(a @ a.T + 9 * np.eye(60), y[:60])[1],
           np.array([math.sin(v) + math.exp(v) + math.hypot(v, 1.0) for v in x])]
print(json.dumps({
    "python": platform.python_version(), "numpy": np.__version__,
    "features": [f for f in core.__cpu_dispatch__ if core.__cpu_features__.get(f)],
    "blas": blas, "bits": [hashlib.md5(r.tobytes()).hexdigest() for r in results]}))
"""


@dataclass(frozen=True)
class Machine:
    """How a Python computes under some setting.

    Attributes
    ----------
    python, numpy : str
        Versions.
    features : tuple of str
        Instructions beyond the least that this numpy uses, by the names that it accepts.
    blas : tuple of str
        What OpenBLAS takes the processor for.
    bits : tuple of str
        Digests of results: equal where every bit is.
    """

    python: str
    numpy: str
    features: tuple[str, ...]
    blas: tuple[str, ...]
    bits: tuple[str, ...]


@dataclass(frozen=True)
class Setting:
    """Variables that make libraries leave something out."""

    name: str
    variables: dict[str, str] = field(default_factory=dict)

    def environment(self) -> dict[str, str]:
        """Return the environment of a process under this setting."""
        single = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        return os.environ | single | self.variables


def look(python: Path, setting: Setting) -> Machine | str:
    """Ask a Python how it computes; what it said instead, where it cannot run so."""
    said = subprocess.run(
        [str(python), "-W", "ignore", "-c", PROBE],
        env=setting.environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    if said.returncode:
        lines = said.stderr.strip().splitlines()
        return lines[-1] if lines else f"ended by signal {-said.returncode}"
    told = json.loads(said.stdout).items()
    frozen: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in told}
    return Machine(**frozen)


def candidates(here: Machine) -> list[Setting]:
    """Return the settings to try for a Python that computes as `here`."""
    simd = {"NPY_DISABLE_CPU_FEATURES": " ".join(here.features)} if here.features else {}
    libm = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX512F,-AVX2,-FMA,-FMA4"}
    oldest = {"OPENBLAS_CORETYPE": CORES[0]}
    return [
        Setting("all three at their least", simd | libm | oldest),
        Setting("numpy without " + " ".join(here.features), simd),
        Setting("C library without AVX2 and FMA", libm),
        *(Setting(f"OpenBLAS for {core}", {"OPENBLAS_CORETYPE": core}) for core in CORES),
    ]


def settings_for(python: Path, quick: bool) -> tuple[list[Setting], list[tuple[str, str]]]:
    """Return the settings that change a result here, and those left out with the reason."""
    here = look(python, Setting("as it is"))
    if isinstance(here, str):
        raise SystemExit(f"{python} cannot compute: {here}")
    print(
        f"Python {here.python}; numpy {here.numpy}, with {' '.join(here.features) or 'nothing'}"
        f" beyond its least; OpenBLAS for {', '.join(here.blas) or 'what threadpoolctl would say'}"
    )
    known, take, left = {here.bits: "as it is"}, [], []
    for setting in candidates(here)[: 1 if quick else None]:
        machine = look(python, setting)
        if isinstance(machine, str):
            left.append((setting.name, f"skipped: {machine}"))
        elif machine.bits in known:
            left.append((setting.name, f"skipped: computes to the bit as {known[machine.bits]!r}"))
        else:
            known[machine.bits] = setting.name
            take.append(setting)
    return take, left


@dataclass(frozen=True)
class Environment:
    """Another Python with other libraries.

    Attributes
    ----------
    minors : tuple of int
        Versions 3.x of Python that will do, the best first.
    requirements : tuple of str
        What is installed, besides the project with its test extra.
    free : tuple of str
        What the constraints leave free; empty frees everything.
    """

    name: str
    minors: tuple[int, ...]
    requirements: tuple[str, ...]
    free: tuple[str, ...] = ()

    def make(self) -> tuple[Path, str]:
        """Make it where it is missing; return its Python, and why it could not be made."""
        folder = ROOT / f".venv-{self.name}"
        python, stamp = folder / "bin/python", folder / ".made"
        if stamp.exists():
            return python, ""
        base = next((p for m in self.minors if (p := find_python((3, m)))), None)
        if base is None:
            versions = " or ".join(f"3.{m}" for m in self.minors)
            return python, f"no Python {versions} on this machine"
        constraints = folder / "constraints.txt"
        subprocess.run([base, "-m", "venv", folder], check=True)
        names = "|".join(self.free) or ".*"
        kept = [
            line
            for line in (ROOT / "constraints.txt").read_text().splitlines()
            if not re.match(rf"({names})==", line)
        ]
        constraints.write_text("\n".join(kept))
        installed = subprocess.run(
            [python, "-m", "pip", "install", "-q", "-c", constraints, *self.requirements,
             "-e", f"{ROOT}[test]"],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        if installed.returncode:
            return python, f"could not be installed: {installed.stderr.strip().splitlines()[-1]}"
        stamp.touch()
        return python, ""


ENVIRONMENTS = (
    # The newest cvxpy and pyarrow need numpy 2, and no Python from 3.13 on has numpy 1.
    Environment("numpy1", (10, 11, 12), ("numpy<2", "pyarrow<20"), ("numpy", "cvxpy", "pyarrow")),
    Environment(
        "testbed",
        (PYTHON[1],),
        tuple(f"{name}=={LIBRARIES[name]}" for name in ("numpy", "scipy", "matplotlib")),
        ("numpy", "scipy", "matplotlib"),
    ),
    Environment("newest", (15, 14, 13, 12), ()),
)


def run(python: Path, setting: Setting, arguments: Sequence[str]) -> str:
    """Run pytest; return its last line."""
    print(f"\n=== {python.parent.parent.name}: {setting.name}", flush=True)
    command = [str(python), "-m", "pytest", "-q", "-n", "2", "--dist", "loadfile", *arguments]
    process = subprocess.Popen(
        command, cwd=ROOT, env=setting.environment(), stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    last = ""
    for line in process.stdout:
        print(line, end="", flush=True)
        last = line.strip() or last
    return last if process.wait() == 0 else f"FAILED: {last}"


def main() -> int:
    """Run what is asked for; return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="only what numbers can touch")
    known = [environment.name for environment in ENVIRONMENTS]
    parser.add_argument("--environment", choices=known, help="only in this one")
    asked, arguments = parser.parse_known_args()
    numbers = [f"tests/test_{name}.py" for name in NUMBERS]
    table: list[tuple[str, str]] = []
    if asked.environment is None:
        python = Path(sys.executable)
        take, table = settings_for(python, asked.quick)
        for setting in take:
            chosen = numbers if asked.quick or setting is not take[0] else []
            table.append((setting.name, run(python, setting, [*chosen, *arguments])))
    for environment in ENVIRONMENTS:
        if asked.environment == environment.name or not (asked.environment or asked.quick):
            python, why_not = environment.make()
            chosen = numbers if asked.quick else []
            result = (
                f"skipped: {why_not}"
                if why_not
                else run(python, Setting("as it is"), [*chosen, *arguments])
            )
            table.append((f"environment {environment.name}", result))
    print()
    for name, result in table:
        print(f"{name:<60} {result}")
    return int(any(result.startswith("FAILED") for _, result in table))


if __name__ == "__main__":
    sys.exit(main())
