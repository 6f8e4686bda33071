"""The checker of docstrings sees what is left out, and what is told that is not so."""

import textwrap
from pathlib import Path

import pytest

pytest.importorskip("numpydoc")
docstrings = pytest.importorskip("tools.docstrings")

#: Everything that the rule asks for, once.
SOUND = '''
from dataclasses import dataclass
from typing import Any
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

@dataclass(frozen=True)
class Limits:
    """What the motors can do.

    Attributes
    ----------
    speed : float
        Largest speed, m/s.
    corners : (2, K) array
        Corners of the polygon, m/s.
    """

    speed: float
    corners: Floats
    _cache: int = 0

    def __post_init__(self) -> None:
        self.check()

    @property
    def sides(self) -> Floats:
        """The (2, K) unit normals of the sides."""
        return self.corners

    def check(self) -> None:
        """Refuse a speed that is not positive.

        Raises
        ------
        ValueError
            Where it is not.
        """
        if self.speed <= 0:
            raise ValueError(self.speed)

def cut(velocity: Floats, limits: Limits, *names: str, strict: bool = False) -> Floats:
    """Return velocities within the limits.

    Parameters
    ----------
    velocity : (2, N) array
        Velocities, m/s.
    limits : Limits
        What the motors can do.
    *names : str
        Robots, for errors.
    strict : bool
        Refuse instead.

    Returns
    -------
    (2, N) array
        Velocities, m/s.

    Raises
    ------
    ValueError, TypeError
        Where that is asked for.
    """
    if strict:
        raise ValueError("too fast")
    def inner() -> None:
        raise KeyError
    raise TypeError
'''


def faults(tmp_path: Path, source: str) -> list[str]:
    """Return what the checker says of a module, without file and line."""
    path = tmp_path / "module.py"
    path.write_text(textwrap.dedent(source), encoding="utf-8")
    return [f"{fault.name}: {fault.text}" for fault in docstrings.check([path], root=tmp_path)]


def test_what_keeps_the_rule_passes(tmp_path):
    assert faults(tmp_path, SOUND) == []


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("    strict : bool\n        Refuse instead.\n", "", "cut: PR01 Parameters {'strict'}"),
        ("    strict : bool\n", "    strictly : bool\n", "cut: PR02 Unknown parameters"),
        ("        Velocities, m/s.\n    limits", "    limits", 'cut: PR07 Parameter "velocity"'),
        ("        Refuse instead.\n", "        The flag.\n", "cut: the description of strict says"),
        ("limits : Limits\n", "limits: Limits\n", "cut: PR10 Parameter"),
        ("velocity : (2, N) array", "velocity : array", "cut: the shape of velocity is missing"),
        ("\n    (2, N) array\n", "\n    array\n", "cut: the shape of what is returned"),
        ("    ValueError, TypeError\n", "    ValueError\n", "cut: TypeError is raised"),
        ("        ValueError\n            Where", "        KeyError\n            Where",
         "Limits.check: ValueError is raised"),
        ("    speed : float\n        Largest speed, m/s.\n", "",
         "Limits: PR01 Parameters {'speed'}"),
        ("corners : (2, K) array", "corners : ndarray", "Limits: the shape of corners is missing"),
        ("The (2, K) unit normals", "The unit normals", "Limits.sides: the shape of what"),
        ('    """Return velocities within the limits.\n', '    """Return velocities\n',
         "cut: SS03 Summary does not end with a period"),
    ],
)  # fmt: skip
def test_a_planted_fault_is_seen(tmp_path, right, wrong, said):
    assert SOUND.count(right) == 1
    found = faults(tmp_path, SOUND.replace(right, wrong))
    assert any(fault.startswith(said) for fault in found), found


def test_arguments_are_told_in_the_order_of_the_signature(tmp_path):
    found = faults(
        tmp_path,
        '''
        def move(x: float, y: float) -> None:
            """Move.

            Parameters
            ----------
            y : float
                Metres.
            x : float
                Metres.
            """
        ''',
    )
    assert [fault[:10] for fault in found] == ["move: PR03"]


def test_a_missing_docstring_is_seen_but_not_of_what_is_private(tmp_path):
    found = faults(
        tmp_path,
        '''
        def _own(x): ...
        class _Own:
            def move(self, x): ...
        def shared(): ...
        class Shared:
            """A class."""
            def move(self): ...
            def __call__(self): ...
            def __len__(self): ...
        ''',
    )
    assert [fault.split(":")[0] for fault in found] == ["shared", "Shared.move", "Shared.__call__"]


def test_a_class_tells_what_its_constructor_takes_and_raises(tmp_path):
    told = faults(
        tmp_path,
        '''
        class Robot:
            """A robot."""
            def __init__(self, radius: float) -> None:
                if radius < 0:
                    raise ValueError(radius)
        ''',
    )
    assert [fault[:18] for fault in told] == ["Robot: PR01 Parame", "Robot: ValueError "]


def test_inherited_fields_and_named_options_may_be_told(tmp_path):
    source = '''
        from dataclasses import dataclass

        @dataclass
        class Base:
            """A base.

            Attributes
            ----------
            gain : float
                1/s.
            """

            gain: float

        @dataclass
        class Derived(Base):
            """More.

            Attributes
            ----------
            radius : float
                m.
            gain : float
                1/s, as above.
            """

            radius: float

        def run(script: str, **options: object) -> None:
            """Run a script.

            Parameters
            ----------
            script : str
                Where it lies.
            seed : int
                Of the run.
            """
        '''
    assert faults(tmp_path, source) == []
    misspelt = source.replace(
        "gain : float\n                1/s, as", "grain : float\n                1/s, as"
    )
    assert [fault[:13] for fault in faults(tmp_path, misspelt)] == ["Derived: PR02"]


def test_a_command_is_told_by_its_options(tmp_path):
    source = '''
        from typing import Annotated
        import typer

        def sweep(out: Annotated[str, typer.Option(help="Folder.")] = "") -> None:
            """Run a study."""
            raise typer.Exit(1)
        '''
    assert faults(tmp_path, source) == []
    assert len(faults(tmp_path, source.replace("typer.Option", "Option"))) == 2
    annotated = 'Annotated[str, typer.Option(help="Folder.")]'
    assert faults(tmp_path, source.replace(annotated, "options.Folder")) == []


def test_only_modules_without_an_underscore_are_held():
    held = docstrings.is_public
    assert held(Path("package/__init__.py"))
    assert held(Path("package/part/module.py"))
    assert not held(Path("package/_part/module.py"))
    assert not held(Path("package/__main__.py"))


#: A Protocol, and what implements it. INHERITS stands where a subclass names its base.
OVERRIDDEN = '''
from typing import Protocol
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

class Effect(Protocol):
    """An imperfection."""

    def begin(self, robots: int, poses: Floats) -> Floats:
        """Draw a run's numbers.

        Parameters
        ----------
        robots : int
            Number of robots, N.
        poses : (3, N) array
            Where they stand, m and rad.

        Returns
        -------
        (N,) array
            A number each.

        Raises
        ------
        ValueError
            There are no robots.
        """

class Lag(INHERITS):
    """Robots follow late."""

    def begin(self, robots: int, poses: Floats) -> Floats:
        """Draw each robot's time constant."""
        if not robots:
            raise ValueError("no robots")
        return poses[0]

class Longer(Lag):
    """Later still."""

    def begin(self, robots: int, poses: Floats) -> Floats:
        return 2 * poses[0]
'''


def test_an_override_tells_only_what_is_new(tmp_path):
    assert faults(tmp_path, OVERRIDDEN.replace("INHERITS", "Effect")) == []
    unnamed = faults(tmp_path, OVERRIDDEN.replace("INHERITS", "object"))
    assert [fault[:20] for fault in unnamed] == [
        "Lag.begin: PR01 Para", "Lag.begin: the shape", "Lag.begin: ValueErro",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ('        """Draw each robot\'s time constant."""\n', "", None),
        ("2 * poses[0]", "1 / 0", None),
        ("2 * poses[0]", "self.fail()\n        raise KeyError", "Longer.begin: KeyError is raised"),
        ('constant."""', 'constant"""', "Lag.begin: SS03"),
        ('raise ValueError("no robots")', "raise TypeError", "Lag.begin: TypeError is raised"),
    ],
)
def test_what_an_override_says_is_still_held(tmp_path, right, wrong, said):
    source = OVERRIDDEN.replace("INHERITS", "Effect")
    assert source.count(right) == 1
    found = faults(tmp_path, source.replace(right, wrong))
    assert [fault.startswith(said) for fault in found] == [True] if said else found == []


def test_an_override_tells_its_own_arguments_and_no_shape_that_its_base_does_not(tmp_path):
    source = OVERRIDDEN.replace("INHERITS", "Effect")
    last = "(self, robots: int, poses: Floats) -> Floats:\n        return"
    assert source.count(last) == 1
    more = source.replace(last, last.replace("Floats)", "Floats, seed: int = 0)"))
    assert [fault[:18] for fault in faults(tmp_path, more)] == ["Longer.begin: GL08"]
    told = 'poses: Floats) -> Floats:\n        """Draw a run\'s'
    assert source.count(told) == 1
    base = source.replace(told, told.replace("-> Floats", "-> object"))
    shapes = [fault for fault in faults(tmp_path, base) if "the shape of what is returned" in fault]
    assert [fault.split(":")[0] for fault in shapes] == ["Lag.begin"]


def test_a_method_that_no_base_tells_has_to_be_told(tmp_path):
    source = OVERRIDDEN.replace("INHERITS", "Effect")
    untold = source.replace("class Longer(Lag):", "class Longer(Elsewhere):")
    assert faults(tmp_path, untold)
    renamed = source.replace("        return 2 * poses[0]", "        return poses[0]\n\n"
                             "    def end(self) -> None: ...")  # fmt: skip
    assert [fault[:16] for fault in faults(tmp_path, renamed)] == ["Longer.end: GL08"]
