"""Which generation a script was written for, and what in it speaks against the one it runs on."""

import ast
import re
import textwrap

import numpy as np
import pytest

import rps_compat
from rps_compat.errors import WrongGenerationError
from rps_compat.generations import evidence_in, evidence_of


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
        for make in (lambda: Robotarium(number_of_robots=1, show_obstacles=True), lambda: Env([])):
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


FIRST_IN_SECOND = """\
from rps.robotarium import Robotarium
from rps.utilities.misc import create_at_pose, generate_random_poses
r = Robotarium(number_of_robots=1, skip_initialization=True)
for _ in range(20):
    r.get_poses()
    r.set_velocities([0], v)
    r.step()
r.call_at_scripts_end()
"""


def test_what_stops_a_script_is_told_with_its_line_and_the_right_name():
    found = evidence(FIRST_IN_SECOND)
    assert found.generation == 2
    assert found.against(2) == [
        "line 8: call_at_scripts_end is generation 1's; running as generation 2, "
        "which calls it debug()"
    ]
    assert len(found.against(1)) == 3
    assert "line 2: create_at_pose is generation 2's" in found.against(1)[0]


LAST_RELEASE = """
from rps.utilities.barrier_certificates import *
r = Robotarium(number_of_robots=3, use_distance_sensors=True, obstacles=walls)
r.get_distances(), r.get_encoders(), r.get_gyros(), r.get_orientations()
"""


def test_sensors_speak_for_generation_2_only_where_nothing_else_speaks():
    assert evidence(LAST_RELEASE).generation == 2
    first = evidence(f"{LAST_RELEASE}create_single_integrator_barrier_certificate()")
    assert (first.generation, first.certain, first.against(1)) == (1, True, [])
    second = evidence(f"{LAST_RELEASE}create_si_barrier_certificate()")
    assert (second.generation, second.certain) == (2, True)


@pytest.mark.parametrize(
    ("source", "generation", "told"),
    [
        ("r = Robotarium(3)", 2, "which takes names only"),
        ("r = Robotarium(show_obstacles=1)", 1, "show_obstacles= is .* no such argument"),
        ("r = Robotarium()\nr.time_step", 2, "line 2: time_step .* calls it TIME_STEP"),
        ("r = Robotarium()\nr.axes.plot()", 2, "calls it _axes_handle"),
        ("r = Robotarium()\nr.debug()", 1, r"calls it call_at_scripts_end\(\)"),
        ("r = Robotarium()\nr.robot_colormap()", 1, "has nothing like it"),
        ("from rps.utilities.misc import *\nat_pose(x, y)", 2, "line 2: at_pose .* create_at_pose"),
        ("import rps.utilities.misc as m\nm.at_pose(x, y)", 2, "line 2: at_pose"),
        ("from rps.utilities.graph import cycle_GL", 2, "calls it cycleGL"),
        ("from rps.utilities.sensors import *", 1, "nothing like it"),
        ("def end(robotarium):\n    robotarium.call_at_scripts_end()", 2, "line 2: call_at"),
        ("try:\n    Robotarium(3)\nexcept KeyboardInterrupt:\n    pass", 2, "line 2: arg"),
        ("class E(Robotarium):\n    def f(self):\n        self.time_step", 2, "line 3: time_step"),
    ],
)
def test_names_that_stop_a_script(source, generation, told):
    (line,) = evidence(source).against(generation)
    assert re.search(told, line)


@pytest.mark.parametrize(
    "source",
    [
        "r = Robotarium()\nif hasattr(r, 'debug'):\n    r.debug()\nelse:\n"
        "    r.call_at_scripts_end()",
        "r = Robotarium()\nt = getattr(r, 'time_step', None) or r.TIME_STEP",
        "r = Robotarium()\ntry:\n    r.debug()\nexcept AttributeError:\n"
        "    r.call_at_scripts_end()",
        "try:\n    from rps.utilities.misc import at_pose\nexcept (ImportError, OSError):\n"
        "    from rps.utilities.misc import create_at_pose",
        "class Car:\n    time_step = 1\n\nprint(Car().time_step, Car().TIME_STEP)",
        "import logging\nlogging.debug()",
        "fig, axes = plt.subplots()\nfig.axes",
        "class E(Robotarium):\n    def f(self):\n        self.time_step = 3\n"
        "        self.time_step",
        "class E(Robotarium):\n    pass\n\nclass Plot:\n    def f(self):\n        self.axes",
        "from rps.utilities.misc import *\ndef at_pose(x):\n    return x\nat_pose(3)",
    ],
)
def test_names_that_stop_nothing(source):
    found = evidence(source)
    assert found.against(1) == found.against(2) == []


def test_a_module_beside_the_script_is_named(tmp_path):
    (tmp_path / "helpers.py").write_text("def end(r):\n    r.call_at_scripts_end()\n")
    script = tmp_path / "script.py"
    script.write_text("import helpers\n")
    (line,) = evidence_in(script).against(2)
    assert line.startswith("helpers.py line 2: call_at_scripts_end")
