"""Builds wheel and source archive, checks them, and tries the wheel as a stranger would.

    python .ci/wheel.py [--python 3.12] [--slim] [--build-only]

Both are built into ``dist/`` and must please twine, check-wheel-contents and pyroma without a word
left. Then, on every Python from 3.10 that this machine has (or the one that is asked for), the
wheel alone is installed into a new environment, in an empty folder: the demonstration, the
examples, a new script and a report have to work there, and the installation must weigh no more
than is promised. ``--slim`` installs it in the slim way, as `docs/reference/dependencies.md`
shows it.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from posflock_robotarium.submission.interpreters import find_python

ROOT = Path(__file__).resolve().parents[1]
DIST = ROOT / "dist"
#: MB of an environment, as promised.
DEFAULT_MB, SLIM_MB = 630, 400
MINORS = range(10, 15)
#: What a stranger does first, in a folder that is empty.
STEPS = (
    "posflock --version",
    "posflock demo --duration 20",
    "posflock examples",
    "posflock new mine",
    "posflock run mine/mine.py -o run",
    "posflock lint experiments/robotarium_9bot.py",
    "posflock report results/nine_robots.npy -o report --no-figures",
)


def run(words: Sequence[str | Path], **options: object) -> str:
    """Run a command; return what it said, or end with it where it failed."""
    done = subprocess.run(
        [str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        text=True, check=False, encoding="utf-8", **options,  # type: ignore[call-overload]
    )  # fmt: skip
    if done.returncode:
        raise SystemExit(
            f"{' '.join(map(str, words))} ended with {done.returncode}:\n{done.stdout}"
        )
    return str(done.stdout)


def build() -> Path:
    """Build both archives and check them; return the wheel."""
    shutil.rmtree(DIST, ignore_errors=True)
    tool = Path(sys.executable).parent
    said = run([sys.executable, "-m", "build", "--outdir", DIST, ROOT])
    warned = re.findall(r".*(?:Deprecat|SetuptoolsWarning|_Warning).*", said)
    if warned:
        raise SystemExit("setuptools warns:\n" + "\n".join(warned))
    (wheel,), (source,) = DIST.glob("*.whl"), DIST.glob("*.tar.gz")
    run([tool / "twine", "check", "--strict", wheel, source])
    run([tool / "check-wheel-contents", wheel], cwd=ROOT)
    rating = run([tool / "pyroma", "--min=10", source])
    print(f"{wheel.name}, {source.name}: clean, {re.findall(r'Final rating: (.*)', rating)}")
    return wheel


def slim_lines() -> list[list[str]]:
    """Return what `docs/reference/dependencies.md` says to install in the slim way."""
    page = (ROOT / "docs/reference/dependencies.md").read_text(encoding="utf-8")
    block = re.search(r"```sh\n((?:pip install .*\n)+)```", page)
    assert block is not None
    return [line.split("#")[0].split()[2:] for line in block[1].splitlines()]


def install(wheel: Path, base: str, folder: Path, slim: bool) -> Path:
    """Make an environment with the wheel; return where its programs are."""
    run([base, "-m", "venv", folder])
    programs = folder / ("Scripts" if os.name == "nt" else "bin")
    for words in slim_lines() if slim else [[str(wheel)]]:
        named = [str(wheel) if word.endswith(".whl") else word for word in words]
        run([programs / "python", "-m", "pip", "install", "-q", *named])
    return programs


def weight(folder: Path) -> float:
    """Return what lies in a folder, MB as the disk counts them."""
    return sum(f.lstat().st_blocks for f in folder.rglob("*") if f.is_file()) * 512 / 2**20


def tried(wheel: Path, base: str, slim: bool) -> str:
    """Install the wheel, do what a stranger does, and return a line about it."""
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as name:
        programs, empty = install(wheel, base, Path(name, "env"), slim), Path(name, "empty")
        installed, mb = time.perf_counter() - begun, weight(Path(name, "env"))
        empty.mkdir()
        path = f"{programs}{os.pathsep}{os.environ['PATH']}"
        for step in STEPS:
            run(["bash", "-c", step], cwd=empty, env=os.environ | {"PATH": path})
    most = SLIM_MB if slim else DEFAULT_MB
    if mb > most:
        raise SystemExit(f"the {'slim' if slim else 'default'} installation has {mb:.0f} MB")
    took = time.perf_counter() - begun
    return f"{mb:.0f} MB of {most}, installed in {installed:.0f} s; {took:.0f} s with all steps"


def main() -> int:
    """Do what is asked for; return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--python", help="only this one, such as 3.12")
    parser.add_argument("--slim", action="store_true", help="install it in the slim way")
    parser.add_argument("--build-only", action="store_true", help="build and check")
    asked = parser.parse_args()
    wheel = build()
    if asked.build_only:
        return 0
    minors = MINORS if asked.python is None else [int(asked.python.partition(".")[2])]
    for minor in minors:
        base = find_python((3, minor))
        told = "not on this machine" if base is None else tried(wheel, str(base), asked.slim)
        print(f"Python 3.{minor}: {told}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
