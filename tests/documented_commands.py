"""The shell commands of the documentation: where they stand, and what they need to run.

Commands stand in fenced blocks (``sh``, ``console``) or, where a page is nothing but a few of them,
in indented lines that begin with `posflock`. Whoever follows a page has files of his own; `FILES`
makes such files.
"""

import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", ROOT / "SECURITY.md", ROOT / "CONTRIBUTING.md"]
PAGES += sorted((ROOT / "docs").rglob("*.md"))

_FENCED = re.compile(r"^```(\w+)\n(.*?)^```", re.M | re.S)
_INDENTED = re.compile(r"(?:^    (?:posflock|dask) .*\n(?:^     +\S.*\n)*)+", re.M)
_SHELL = {"sh", "bash", "console"}

#: Commands that run elsewhere, by how they begin, and the test that does what they do.
ELSEWHERE = {
    "make": "test_documentation_commands.py: every target of make is one of the Makefile",
    "pip install": "test_wheel.py: the wheel in a new environment",
    "dask": "test_sweep_cluster.py: schedulers and workers of this machine",
    "posflock sweep study.toml --scheduler": "test_sweep_cluster.py: tls://",
    "posflock sweep experiments/studies/noise.toml --scheduler": "test_sweep_cluster.py: tcp://",
}
#: Pages whose commands, with what they print, have a test of their own.
PAGES_ELSEWHERE = {"own-question.md": "test_own_question_page.py"}
#: Words that make a command do the same for fewer runs.
LIGHTER = {
    "posflock reproduce": "--seeds 2",
    "posflock verify": "-n 2",
    "python mine/mine_train.py": "--generations 1",  # all of it: test_learning_policies.py
}
#: Words that make a command end by itself; its own come after them.
ENDING = {"posflock watch": "--no-open --no-stay --speed max"}
#: Exit codes that mean that something was found.
FINDINGS = {"posflock lint": 1, "posflock verify": 1, "diff": 1}


@dataclass(frozen=True)
class Command:
    """A command as a page shows it.

    Attributes
    ----------
    words : str
        As a shell takes it.
    shown : tuple of str
        Lines that the page shows as what it prints.
    """

    words: str
    shown: tuple[str, ...] = ()

    @property
    def elsewhere(self) -> str | None:
        """Which test runs it instead, if not the test of its page."""
        return next((by for start, by in ELSEWHERE.items() if self.words.startswith(start)), None)

    @property
    def light(self) -> str:
        """The command, for as few runs as it takes to see that it works."""
        fewer = [more for start, more in LIGHTER.items() if self.words.startswith(start)]
        words = self.words
        for start, more in ENDING.items():
            words = words.replace(start, f"{start} {more}", 1)
        return " ".join([words, *fewer])

    @property
    def exit_codes(self) -> set[int]:
        """What it may end with."""
        return {0} | {code for start, code in FINDINGS.items() if self.words.startswith(start)}


def commands(page: Path) -> list[Command]:
    """Return the commands of a page, in order."""
    text = page.read_text(encoding="utf-8")
    found: list[tuple[int, list[Command]]] = []
    for block in _FENCED.finditer(text):
        if block[1] in _SHELL:
            found.append((block.start(), _in_block(block[2], block[1] == "console")))
    bare = _FENCED.sub(lambda block: "\n" * block[0].count("\n"), text)
    for block in _INDENTED.finditer(bare):
        lines = "\n".join(line.removeprefix("    ") for line in block[0].splitlines())
        found.append((block.start(), _in_block(lines, False)))
    return [command for _, block in found for command in block]


def _in_block(text: str, prompts: bool) -> list[Command]:
    found: list[Command] = []
    for line in re.sub(r" *\\\n *", " ", text).splitlines():
        if prompts and not line.startswith("$ "):
            last = found.pop()
            found.append(Command(last.words, (*last.shown, line)))
        elif words := re.sub(r"\s+#.*", "", line.removeprefix("$ ")).strip():
            found.append(Command(words))
    return found


# --- What a reader has ---------------------------------------------------------------------------


def _log(path: Path, offset: float = 0.0, robots: int = 4) -> None:
    """A pose log of robots that circle, as the recorder writes it, with their commands."""
    from posflock_robotarium.flocking.pose_log import PoseLog

    steps, dt, v, w = 900, 0.033, 0.1, 0.3
    path.parent.mkdir(parents=True, exist_ok=True)
    chance = np.random.default_rng(int(100 * offset) + 3)
    with PoseLog(path, robots, steps, {"time_step": dt, "neighbour_radius": 0.75}) as log:
        theta = np.linspace(0.0, 0.5, robots)
        poses = np.stack([np.linspace(-0.8, 0.8, robots), np.full(robots, offset), theta])
        for k in range(steps):
            command = np.array([np.full(robots, v), np.full(robots, w * np.sign(np.sin(k / 90)))])
            log.append(k * dt, poses, command=command)
            moved = np.stack([v * np.cos(poses[2]), v * np.sin(poses[2]), command[1]])
            poses = poses + dt * moved + 1e-4 * chance.normal(size=poses.shape)


def _nine_robots(path: Path) -> None:
    """What `posflock demo` leaves."""
    command = [sys.executable, "-m", "posflock_robotarium", "demo", "-o", str(path.parent)]
    subprocess.run(command, check=True, capture_output=True, cwd=path.parent)


def _script(path: Path) -> None:
    path.write_text(
        "import numpy as np\n"
        "from rps.robotarium import Robotarium\n"
        "STEPS = 300\n"
        "SPEED = 0.08\n"
        "start = np.array([[-0.5, 0.5], [0.3, -0.3], [0.0, np.pi]])\n"
        "r = Robotarium(number_of_robots=2, initial_conditions=start)\n"
        "seen, gates = [], [0.2, 0.4]\n"
        "try:\n"
        "    for k in range(STEPS):\n"
        "        x = r.get_poses()\n"
        "        seen.append(x)\n"
        "        if gates and np.hypot(*(x - start)[:2, 0]) > gates[0]:\n"
        "            print(f'[t={k * 0.033:5.1f}s] at gate {gates.pop(0)}')\n"
        "        r.set_velocities(np.arange(2), np.array([[SPEED, SPEED], [0.0, 0.0]]))\n"
        "        r.step()\n"
        "finally:\n"
        "    np.save('poses.npy', np.array(seen))\n"
        "r.debug()\n"
    )


def _poses(robots: int = 3, steps: int = 600) -> tuple[np.ndarray, np.ndarray]:
    t = 0.033 * np.arange(steps)
    poses = np.zeros((steps, 3, robots))
    poses[:, 0] = 0.02 * t[:, np.newaxis] + np.linspace(-0.6, 0.0, robots)
    poses[:, 1] = np.linspace(-0.2, 0.3, robots)
    return t, poses


def _mat(path: Path) -> None:
    from scipy.io import savemat

    savemat(path, {path.stem: _poses()[1].transpose(1, 2, 0)})


def _csv(path: Path, steps: int = 600) -> None:
    t, poses = _poses(robots=2, steps=steps)
    rows = np.column_stack([t, poses[:, :, 0], poses[:, :, 1]])
    np.savetxt(path, rows, delimiter=",", fmt="%.6f")


def _track(path: Path) -> None:
    t, poses = _poses(robots=1)
    rows = np.column_stack([t, 100 * poses[:, :2, 0], np.degrees(poses[:, 2, 0])])
    np.savetxt(path, rows, delimiter=",", fmt="%.4f", header="t,x1,y1,theta1", comments="")


def _flat(path: Path) -> None:
    np.save(path, _poses()[1].transpose(2, 1, 0).reshape(9, -1))


def _commanded(path: Path) -> None:
    from posflock_robotarium.logs.convert import convert
    from posflock_robotarium.logs.readers import read

    _log(path.with_name("for-npz.npy"))
    convert(read(path.with_name("for-npz.npy")), path)


def _two_seeds(path: Path) -> None:
    for seed in (0, 1):
        _log(path.parents[1] / f"seed-{seed}" / "nine_robots", 0.1 * seed)


#: Who makes a file that a page takes for granted, by what its commands name.
FILES: dict[str, Callable[[Path], None]] = {
    "results/nine_robots.npy": _nine_robots,
    "simulated.npy": _log,
    "returned.npy": lambda path: _log(path, 0.1),
    "back/nine_robots.npy": _log,
    "seed-*/nine_robots.npy": _two_seeds,
    "poses.mat": _mat,
    "robotarium_data.mat": _mat,
    "table.csv": _csv,
    "tracked.csv": lambda path: _csv(path, 1800),
    "track.csv": _track,
    "flat.npy": _flat,
    "run.npz": _commanded,
    "steps.txt": lambda path: np.savetxt(path, np.full(899, 0.0352)),
    "printed.txt": lambda path: path.write_text("[t=  3.2s] at gate 0.2\n[t=  6.2s] at gate 0.4\n"),
    "main.py": _script,
    "formation.py": _script,
}


def supply(page: Path, folder: Path) -> None:
    """Put into a folder what the commands of a page take for granted."""
    words = {word for command in commands(page) for word in command.words.split()}
    words |= set(re.findall(r'^script = "(.*)"', page.read_text(encoding="utf-8"), re.M))
    for name, make in FILES.items():
        if name in words:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            make(folder / name)
