"""Builds wheel and source archive, checks them, and tries the wheel as a stranger would.

    python .ci/wheel.py [--python 3.12] [--slim] [--build-only] [--quick]

Both are built into ``dist/`` and must please twine, check-wheel-contents and pyroma without a word
left. Then, on every Python from 3.10 that this machine has (or the one that is asked for), the
wheel alone is installed into a new environment, in an empty folder: the demonstration, the
examples, a new script, its verdict and a report have to work there, and the installation must weigh
no more than is promised. Libraries are the newest there are, and on the testbed's Python once more
the testbed's. ``--slim`` installs it in the slim way, as `docs/reference/dependencies.md` shows it.

``--quick`` is what every change has to pass: the newest Python with the newest libraries, and at
the same time the testbed's Python, slim, with the testbed's libraries.
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from posflock_robotarium.submission.interpreters import find_python

ROOT = Path(__file__).resolve().parents[1]
DIST = ROOT / "dist"
#: MB of an environment, as promised.
DEFAULT_MB, SLIM_MB = 630, 400
MINORS = range(10, 15)
#: The testbed's, as `.ci/testbed.txt` has its libraries.
TESTBED = 10
#: What a stranger does first, in a folder that is empty.
STEPS = (
    "posflock --version",
    "posflock demo --duration 20",
    "posflock examples",
    "posflock new mine --kind formation",
    "posflock verify mine/mine.py -n 2",
    "posflock run -o run mine/mine.py",
    "posflock report run/poses.npy -o page",
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
    rated = re.findall(r"Final rating: (.*)", rating)
    print(f"{wheel.name}, {source.name}: clean, {rated}", flush=True)
    return wheel


def slim_lines() -> list[list[str]]:
    """Return what `docs/reference/dependencies.md` says to install in the slim way."""
    page = (ROOT / "docs/reference/dependencies.md").read_text(encoding="utf-8")
    block = re.search(r"```sh\n((?:pip install .*\n)+)```", page)
    assert block is not None
    return [line.split("#")[0].split()[2:] for line in block[1].splitlines()]


@dataclass(frozen=True)
class Try:
    """One environment, and what is done in it.

    Attributes
    ----------
    minor : int
        Of its Python, 3.x.
    slim : bool
        Whether it is installed in the slim way.
    testbed : bool
        Whether with the testbed's libraries; else with the newest.
    weighed : bool
        Whether what is installed is compiled and weighed, as pip leaves it.
    """

    minor: int
    slim: bool = False
    testbed: bool = False
    weighed: bool = True

    def __str__(self) -> str:
        libraries = "the testbed's libraries" if self.testbed else "the newest libraries"
        return f"Python 3.{self.minor}, {libraries}{', slim' if self.slim else ''}"

    def told(self, wheel: Path) -> str:
        """Do it, where this machine has such a Python; return a line about it."""
        base = find_python((3, self.minor))
        return f"{self}: {'not on this machine' if base is None else self._tried(wheel, base)}"

    def _tried(self, wheel: Path, base: Path) -> str:
        """Install the wheel, do what a stranger does, and return what it weighs and takes."""
        begun = time.perf_counter()
        with tempfile.TemporaryDirectory() as name:
            programs, empty = self._install(wheel, base, Path(name, "env")), Path(name, "empty")
            installed, mb = time.perf_counter() - begun, weight(Path(name, "env"))
            empty.mkdir()
            took = [f"install {installed:.0f}"]
            for step in STEPS:
                entered = time.perf_counter()
                program, *words = shlex.split(step)
                run([programs / program, *words], cwd=empty, env=strangers_environment(programs))
                took.append(f"{words[0].strip('-')} {time.perf_counter() - entered:.0f}")
        most = SLIM_MB if self.slim else DEFAULT_MB
        if self.weighed and mb > most:
            raise SystemExit(f"{self}: {mb:.0f} MB, promised are {most}")
        weighed = f"{mb:.0f} MB of {most}; " if self.weighed else ""
        return f"{weighed}{time.perf_counter() - begun:.0f} s ({', '.join(took)})"

    def _install(self, wheel: Path, base: Path, folder: Path) -> Path:
        """Make an environment with the wheel; return where its programs are."""
        run([base, "-m", "venv", folder])
        programs = folder / ("Scripts" if os.name == "nt" else "bin")
        options = ["-c", ROOT / ".ci/testbed.txt"] if self.testbed else []
        options += [] if self.weighed else ["--no-compile"]
        for words in slim_lines() if self.slim else [[str(wheel)]]:
            named = [str(wheel) if word.endswith(".whl") else word for word in words]
            run([programs / "python", "-m", "pip", "install", "-q", *options, *named])
        return programs


def strangers_environment(programs: Path) -> dict[str, str]:
    """Return the variables of somebody who has nothing but the new environment."""
    ours = {"PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV", "COVERAGE_PROCESS_START"}
    kept = {name: value for name, value in os.environ.items() if name not in ours}
    return kept | {"PATH": f"{programs}{os.pathsep}{os.environ['PATH']}", "MPLBACKEND": "agg"}


def weight(folder: Path) -> float:
    """Return what lies in a folder, MB as the disk counts them."""
    return sum(f.lstat().st_blocks for f in folder.rglob("*") if f.is_file()) * 512 / 2**20


def tries(asked: argparse.Namespace) -> list[Try]:
    """Return what is to be tried."""
    if asked.quick:
        newest = next(m for m in reversed(MINORS) if find_python((3, m)) is not None)
        return [Try(newest, weighed=False), Try(TESTBED, slim=True, testbed=True, weighed=False)]
    minors = MINORS if asked.python is None else [int(asked.python.partition(".")[2])]
    found = [Try(minor, asked.slim) for minor in minors]
    return found + [Try(TESTBED, asked.slim, testbed=True) for minor in minors if minor == TESTBED]


def main() -> int:
    """Do what is asked for; return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--python", help="only this one, such as 3.12")
    parser.add_argument("--slim", action="store_true", help="install it in the slim way")
    parser.add_argument("--build-only", action="store_true", help="build and check")
    parser.add_argument("--quick", action="store_true", help="two environments at a time")
    asked = parser.parse_args()
    wheel = build()
    with ThreadPoolExecutor(2 if asked.quick else 1) as pool:
        for told in [] if asked.build_only else pool.map(lambda t: t.told(wheel), tries(asked)):
            print(told, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
