"""Which generation a script was written for, and what in it speaks against the one it runs on."""

import ast
import textwrap

import numpy as np
import pytest

import rps_compat
from rps_compat.errors import WrongGenerationError
from rps_compat.generations import evidence_of


def evidence(source):
    return evidence_of([ast.parse(textwrap.dedent(source))])


@pytest.mark.parametrize(
    ("source", "generation"),
    [
        ("r = Robotarium(number_of_robots=3, skip_initialization=True)", 2),
        ("r = Robotarium(3)", 1),
        (
            """
            class Env(Robotarium):
                def __init__(self, robots):
                    super().__init__(number_of_robots=robots, skip_initialization=True)
            """,
            2,
        ),
        (
            """
            class Env(rps.robotarium.Robotarium):
                def __init__(self, robots):
                    super(Env, self).__init__(robots, True)
            """,
            1,
        ),
        (
            """
            class Base(Robotarium):
                def __init__(self, **options):
                    Robotarium.__init__(self, use_distance_sensors=True, **options)
            """,
            2,
        ),
        (
            """
            class Base(Robotarium):
                pass

            class Env(Base):
                def __init__(self):
                    super().__init__(number_of_robots=4, obstacles=walls)
            """,
            2,
        ),
        (
            """
            class Base(Robotarium):
                pass

            env = Base(number_of_robots=4, skip_initialization=True)
            """,
            2,
        ),
    ],
)
def test_constructor_tells_the_generation(source, generation):
    found = evidence(source)
    assert found.certain
    assert found.generation == generation


@pytest.mark.parametrize(
    "source",
    [
        """
        class Env(Gym):
            def __init__(self):
                super().__init__(3, obstacles=[])
        """,
        """
        class Env(Robotarium):
            def __init__(self, obstacles):
                super().__init__(number_of_robots=3)

        Env(obstacles=[])
        """,
        """
        class Env(Robotarium):
            class Inner(Gym):
                def __init__(self):
                    super().__init__(3)
        """,
    ],
)
def test_other_constructors_tell_nothing(source):
    found = evidence(source)
    assert (found.first, found.second) == ((), ())


def test_arguments_of_generation_2_are_answered_by_generation_1():
    rps_compat.install(api=1)
    from rps.robotarium import Robotarium

    class Env(Robotarium):
        def __init__(self, obstacles):
            super().__init__(number_of_robots=1, skip_initialization=bool(obstacles))

    try:
        for make in (lambda: Robotarium(number_of_robots=1, obstacles=[]), lambda: Env([])):
            with pytest.raises(WrongGenerationError, match="is generation 2's: run with --api 2"):
                make()
        # Scripts that try one generation and then the other catch what Python raises there.
        with pytest.raises(TypeError, match="skip_initialization"):
            Robotarium(number_of_robots=1, skip_initialization=True)
        with pytest.raises(TypeError, match="number_of_robot"):
            Robotarium(number_of_robot=1)
        assert Robotarium(1, False, False, np.zeros((3, 1))).number_of_robots == 1
    finally:
        rps_compat.uninstall()
