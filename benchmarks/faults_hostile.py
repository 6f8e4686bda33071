"""Forty hostile and careless scripts, in both containments: the verdict true, the machine clean.

The scripts, and the machine that they are let loose on, are those of ``tests/hostile_cases.py``.

    python benchmarks/faults_hostile.py
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from comparing import Table

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from hostile_cases import (
    NATIVE,
    SCRIPTS,
    Machine,
    becomes,
    containments,
    table,
    wrong,
)

from posflock_robotarium.verify.trials import ForkServer
from rps_compat.containment.namespaces import VARIABLE, Containment


def tried(half: str, how: Containment, told: Table) -> None:
    """Verify all scripts in one half of the containment; print what is wrong, and count it."""
    os.environ[VARIABLE] = how.value
    print(f"{half}: {how.about}")
    with Machine() as machine:
        with ForkServer() as server:
            faults = {path.name: wrong(path, server, machine) for path in SCRIPTS}
            native = {path.stem: becomes(path, server, machine) for path in NATIVE}
        left = machine.left_running()
    said = {name: words[half == "hook"] for name, words in table().items()}
    others = {name: word for name, word in native.items() if word != said.get(name)}
    for name, words in faults.items():
        if words:
            print(f"    {name}: {'; '.join(words)}")
    for name, word in others.items():
        print(f"    {name}: {word}, and SECURITY.md says {said.get(name)}")
    told.bar(f"scripts, {half}", len(SCRIPTS), "≥", 40)
    told.bar("  with a wrong verdict, or damage done", sum(map(bool, faults.values())), "≤", 0)
    told.bar("  native ones that are not as SECURITY.md says", len(others), "≤", 0)
    told.bar("  processes left running", len(left), "≤", 0)


def main() -> int:
    """Try both halves, as far as the kernel has them; 1 where anything is wrong."""
    told = Table()
    for half, how in containments().items():
        if how is None:
            print(f"{half}: the kernel refuses them here, so that this half is not tried")
        else:
            tried(half, how, told)
    return told.exit_code()


if __name__ == "__main__":
    sys.exit(main())
