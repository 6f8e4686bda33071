"""A script to begin with: complete, ready to submit, with the metric that it is judged by.

What a newcomer needs first is an experiment that works and that he can change a line of. Each kind
is a template that fills a folder: the script, which logs itself and keeps its robots apart; a file
with its metric, which reads any log of it, from here or from the testbed; and a page that says what
to do with them.
"""

from __future__ import annotations

import keyword
import re
from dataclasses import dataclass
from enum import Enum
from importlib import resources
from pathlib import Path

from posflock_robotarium.flocking.errors import OutputError, ParameterError
from rps_compat.whole_files import write_whole, written_together


@dataclass(frozen=True)
class KindOfScript:
    """What a kind of experiment tells of itself.

    Attributes
    ----------
    summary : str
        One sentence, without its full stop.
    robots : int
        How many take part.
    duration : float
        Seconds that it takes.
    metric, unit, meaning : str
        What it is judged by, in what, and what that means.
    shared : str
        What the script takes from the metric's file.
    given : str
        What its law is given beside the poses.
    law : str
        Where its law stands, in words.
    questions : str
        What its report asks of it, as ``--questions`` has it; empty where the log tells that.
    constant, tried : str
        A constant of it that a study may vary, and values for that.
    speed : float
        How fast a robot is to be at most, m/s.
    trained : bool
        Whether weights belong to it, and a script that trains them.
    """

    summary: str
    robots: int
    duration: float
    metric: str
    unit: str
    meaning: str
    shared: str = "METRIC, UNIT, metric"
    given: str = ""
    law: str = "`desired`, at the bottom of the script"
    questions: str = ""
    constant: str = "SPEED"
    tried: str = "[0.06, 0.09, 0.12]"
    speed: float = 0.12
    trained: bool = False

    @property
    def asked(self) -> str:
        """The option of `posflock report` that asks it."""
        return f" --questions {self.questions}" if self.questions else ""

    @property
    def metric_name(self) -> str:
        """Its metric as a function is called."""
        return self.metric.replace(" ", "_")


class ExperimentKind(str, Enum):
    """The kinds of experiment that there are."""

    FLOCKING = "flocking"
    FORMATION = "formation"
    COVERAGE = "coverage"
    SWARM_SWAP = "swarm-swap"
    POLICY = "policy"

    @property
    def kind(self) -> KindOfScript:
        """What it tells of itself."""
        return _KINDS[self]


_KINDS = {
    ExperimentKind.FLOCKING: KindOfScript(
        "Flocking: six robots align without measuring any velocity.",
        6,
        90.0,
        "order parameter",
        "",
        "The length of the mean heading: 1 where all look one way, 0 where they cancel.",
        constant="ROBOTS",
        tried="[4, 6, 9]",
        law="`LAW` with `Flock`; `posflock_robotarium.flocking.law` has it as pure functions",
    ),
    ExperimentKind.FORMATION: KindOfScript(
        "Formation: six robots take their places in a hexagon.",
        6,
        60.0,
        "formation error",
        "m",
        "The mean distance of a robot from its place in the formation, wherever that stands.",
        shared="METRIC, PLACES, UNIT, metric",
        given="places",
        questions="formation",
    ),
    ExperimentKind.COVERAGE: KindOfScript(
        "Coverage: six robots spread over the arena.",
        6,
        60.0,
        "distance to the nearest robot",
        "m",
        "The mean over the arena of how far the nearest robot is.",
        shared="GRID, METRIC, UNIT, metric, nearest_robot",
        given="weight",
        questions="coverage",
    ),
    ExperimentKind.SWARM_SWAP: KindOfScript(
        "Swap: six robots on a circle change places with who is opposite.",
        6,
        90.0,
        "distance to the goal",
        "m",
        "The mean distance of a robot from where it is to go.",
        shared="GOALS, METRIC, UNIT, metric",
        given="GOALS",
    ),
    ExperimentKind.POLICY: KindOfScript(
        "Policy: eight robots change places as they have learnt to, by weights from a file.",
        8,
        60.0,
        "distance to the goal",
        "m",
        "The mean distance of a robot's look-ahead point from where it is to go.",
        shared="GOALS, METRIC, START, UNIT, metric",
        given="GOALS",
        law="`POLICY`, trained by `*_train.py`; `desired`, at the bottom, has it drive",
        tried="[0.09, 0.12, 0.15]",
        speed=0.15,
        trained=True,
    ),
}


def write_script(name: str, experiment: ExperimentKind, folder: Path) -> list[Path]:
    """Write a new experiment into a folder of its own; return the files, the script first.

    Parameters
    ----------
    name : str
        Of the script, without an ending; a name as Python has them.
    experiment : ExperimentKind
        Which kind.
    folder : Path
        Where the folder, called `name`, is made.

    Raises
    ------
    ParameterError
        Where the name cannot be that of a script on the testbed.
    OutputError
        Where the folder is there already and not empty, or cannot be written.
    """
    require_script_name(name)
    home = folder / name
    if home.exists() and (not home.is_dir() or any(home.iterdir())):
        raise OutputError(
            f"{home} is there already; choose another name, or another folder with -o"
        )
    from jinja2 import Environment, PackageLoader, StrictUndefined

    templates = Environment(  # no page: a script, in which < is <
        loader=PackageLoader("posflock_robotarium.new_script", "assets"),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
        autoescape=False,
    )
    files = {
        f"{name}.py": f"{experiment.value}.py.j2",
        f"{name}_metric.py": f"{experiment.value}_metric.py.j2",
        "README.md": "README.md.j2",
    }
    if experiment.kind.trained:
        files[f"{name}_train.py"] = f"{experiment.value}_train.py.j2"
    with written_together(home) as draft:
        for file, template in files.items():
            text = templates.get_template(template).render(name=name, kind=experiment.kind)
            write_whole(draft / file, text)
        if experiment.kind.trained:
            weights = resources.files(__name__) / "assets" / f"{experiment.value}_weights.npy"
            write_whole(draft / f"{name}_weights.npy", weights.read_bytes())
            files[f"{name}_weights.npy"] = weights.name
    return [home / file for file in files]


def require_script_name(name: str) -> None:
    """Refuse a name that a script on the testbed cannot have.

    Parameters
    ----------
    name : str
        Without an ending.

    Raises
    ------
    ParameterError
        Naming the reason.
    """
    from rps_compat.scripts.libraries import shadowed_by

    expected = "expected a name as Python has them, such as my_flock"
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) or keyword.iskeyword(name):
        raise ParameterError(f"{name!r} cannot be a script's name: {expected}")
    if name.lower() == "main":
        raise ParameterError("main.py is what the testbed calls every script: choose another name")
    hidden = shadowed_by(name)
    if hidden is not None:
        raise ParameterError(f"{name}.py would hide {hidden}: choose another name")


__all__ = ["ExperimentKind", "KindOfScript", "write_script"]
