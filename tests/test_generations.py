"""Which generation a script was written for, and what in it speaks against the one it runs on."""

import re
import textwrap

import numpy as np
import pytest

import rps_compat
from rps_compat.errors import WrongGenerationError
from rps_compat.scripts.evidence import evidence_in
from rps_compat.scripts.interpretation import interpret
from rps_compat.scripts.source import parse_script

ROBOTARIUM = "from rps.robotarium import Robotarium\n"


def evidence(source, folder="nowhere"):
    return evidence_in(interpret(parse_script(textwrap.dedent(source).encode(), f"{folder}/s.py")))


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
            import rps.robotarium
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
                    Robotarium.__init__(self, show_distance_rays=True, **options)
            """,
            2,
        ),
        (
            """
            class Base(Robotarium):
                pass

            class Env(Base):
                def __init__(self):
                    super().__init__(number_of_robots=4, show_obstacles=True)
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
        # Arguments that a function of both generations has in one only.
        ("from rps.utilities.graph import lineGL\nlineGL(N=3)", 1),
        ("import rps.utilities.graph as g\ng.lineGL(n=3)", 2),
        (
            "from rps.utilities.transformations import *\n"
            "create_si_to_uni_mapping(angular_velocity_limit=3)",
            1,
        ),
        # Names that only generation 1's star brings along.
        ("from rps.utilities.misc import *\nplt.figure()", 1),
    ],
)
def test_the_source_tells_the_generation(source, generation):
    found = evidence(ROBOTARIUM + textwrap.dedent(source))
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
        "from elsewhere import Robotarium\nRobotarium(3)",
    ],
)
def test_other_constructors_tell_nothing(source):
    found = evidence(ROBOTARIUM + textwrap.dedent(source))
    assert found.nothing
    assert found.generation == 2


def test_what_tells_nothing_is_generation_2():
    assert evidence(ROBOTARIUM + "r = Robotarium(number_of_robots=1)\nr.step()\n").generation == 2
    both = ROBOTARIUM + (
        "r = Robotarium(number_of_robots=1)\n"
        "r.debug() if hasattr(r, 'debug') else r.call_at_scripts_end()\n"
    )
    assert evidence(both).generation == 2
    assert not evidence(both).certain


def test_the_idiom_of_the_published_examples_is_generation_2():
    found = evidence(
        """
        import rps.robotarium as robotarium
        from rps.utilities.misc import *
        from rps.utilities.controllers import *
        r = robotarium.Robotarium(number_of_robots=3, show_figure=True)
        at_pose = create_at_pose(0.05)
        generate_initial_conditions = generate_random_poses
        x = r.get_poses()
        while not all(at_pose(x, goals)[0]):
            x = r.get_poses()
            r.step()
        r.debug()
        """
    )
    assert found.generation == 2
    assert found.against(2) == []


def test_arguments_of_generation_2_are_answered_by_generation_1():
    rps_compat.install(generation=1)
    from rps.robotarium import Robotarium

    class Env(Robotarium):
        def __init__(self, obstacles):
            super().__init__(number_of_robots=1, skip_initialization=bool(obstacles))

    try:
        for make in (lambda: Robotarium(number_of_robots=1, show_obstacles=True), lambda: Env([])):
            with pytest.raises(
                WrongGenerationError, match="is generation 2's: run with --generation 2"
            ):
                make()
        # Scripts that try one generation and then the other catch what Python raises there.
        with pytest.raises(TypeError, match="skip_initialization"):
            Robotarium(number_of_robots=1, skip_initialization=True)
        with pytest.raises(TypeError, match="number_of_robot"):
            Robotarium(number_of_robot=1)
        with pytest.raises(TypeError, match="2017 to 2019; write number_of_robots"):
            Robotarium(number_of_agents=1)
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
        "line 8: call_at_scripts_end() is generation 1's; generation 2 calls it debug()"
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
        ("r = Robotarium(3)", 2, "takes them by name only"),
        (
            "r = Robotarium(show_obstacles=1)",
            1,
            "show_obstacles= of .* no such argument",
        ),
        ("r = Robotarium()\nr.time_step", 2, "line 3: time_step .* calls it TIME_STEP"),
        ("r = Robotarium()\nr.axes.plot()", 2, "calls it _axes_handle"),
        ("r = Robotarium()\nr.boundaries", 2, "calls it BOUNDARIES.*x_min, x_max"),
        ("r = Robotarium()\nr.debug()", 1, r"calls it call_at_scripts_end\(\)"),
        ("r = Robotarium()\nr.robot_colormap()", 1, "has nothing like it"),
        ("from rps.utilities.misc import *\nat_pose(x, y)", 2, "line 3: at_pose .* create_at_pose"),
        ("import rps.utilities.misc as m\nm.at_pose(x, y)", 2, "line 3: at_pose"),
        ("from rps.utilities import misc as m\nm.at_pose(x, y)", 2, "line 3: at_pose"),
        ("import rps.utilities.misc\nrps.utilities.misc.at_pose(x, y)", 2, "line 3: at_pose"),
        ("from rps.utilities.graph import cycle_GL", 2, "calls it cycleGL"),
        ("from rps.utilities.sensors import *", 1, "nothing like it"),
        ("from rps.utilities.obstacles import *", 2, "is in no generation of the API"),
        ("from rps.utilities.misc import nonsense", 1, "is in no generation of the API"),
        ("from rps.utilities.misc import *\nplt.show()", 2, "import matplotlib.pyplot as plt"),
        ("def end(robotarium):\n    robotarium.call_at_scripts_end()", 2, "line 3: call_at"),
        ("try:\n    Robotarium(3)\nexcept KeyboardInterrupt:\n    pass", 2, "line 3: Robotarium"),
        ("class E(Robotarium):\n    def f(self):\n        self.time_step", 2, "line 4: time_step"),
        ("def make():\n    return Robotarium()\nmake().time_step", 2, "line 4: time_step"),
        ("def end(r):\n    r.poses\nend(Robotarium())", 2, "line 3: poses"),
        ("def end(r: Robotarium):\n    r.poses", 2, "line 3: poses"),
        ("def end(r: 'Robotarium | None' = None):\n    r.poses", 2, "line 3: poses"),
        ("for r in [Robotarium() for _ in range(3)]:\n    r.poses", 2, "line 3: poses"),
        ("with open('x') as f, Robotarium() as r:\n    r.poses", 2, "line 3: poses"),
        ("if (r := Robotarium()):\n    r.poses", 2, "line 3: poses"),
        ("r, n = Robotarium(), 3\nr.poses", 2, "line 3: poses"),
        (
            "r = None\ndef f():\n    global r\n    r = Robotarium()\nf()\nr.poses",
            2,
            "line 7: poses",
        ),
        (
            "class T:\n    def __init__(self, r):\n        self.r = r\nT(Robotarium()).r.poses",
            2,
            "5",
        ),
        ("team = {}\nteam['r'] = Robotarium()\nteam['r'].poses", 2, "line 4: poses"),
        ("match Robotarium():\n    case r:\n        r.poses", 2, "line 4: poses"),
        # Before the function has its name, the star's is meant.
        (
            "from rps.utilities.misc import *\nat_pose(x, y)\nat_pose = create_at_pose()",
            2,
            "line 3: at_pose",
        ),
    ],
)
def test_names_that_stop_a_script(source, generation, told):
    (line,) = evidence(ROBOTARIUM + source).against(generation)
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
        "from rps.utilities.misc import *\nfor at_pose in [len]:\n    at_pose('x')",
        "from rps.utilities.misc import *\ndef f(at_pose):\n    at_pose(3)",
        "from rps.utilities.misc import *\n[at_pose for at_pose in []]",
        "from rps.utilities.misc import *\nwith open('x') as at_pose:\n    at_pose.read()",
        "from rps.utilities.misc import *\nat_pose = lambda *a: a\ndef f():\n    at_pose(3)",
        "from mine import *\nat_pose(3)",
        "at_pose(3)",
        "def f(r):\n    r.poses\nf(Camera())",
        "class call_at:\n    def call_at_scripts_end(self): pass\ndef f(x):\n"
        "    x.call_at_scripts_end()",
        "at_pose = 3\nprint(at_pose)",
        "from rps.utilities import misc\nprint(misc.__name__, misc.__file__)",
    ],
)
def test_names_that_stop_nothing(source):
    found = evidence(ROBOTARIUM + source)
    assert found.against(1) == found.against(2) == []


def test_a_whole_program_in_try_is_not_ready_for_a_wrong_name():
    source = ROBOTARIUM + (
        "try:\n    r = Robotarium(number_of_robots=1)\n    for k in range(3):\n"
        "        r.get_poses()\n        r.step()\n    r.call_at_scripts_end()\n"
        "except Exception as error:\n    print(error)\n"
    )
    assert len(evidence(source).against(2)) == 1


def test_a_module_beside_the_script_is_read_with_it(tmp_path):
    (tmp_path / "helpers.py").write_text("def end(r):\n    r.poses\n    r.call_at_scripts_end()\n")
    (tmp_path / "init.py").write_text("from rps.robotarium import *\nr = Robotarium(3)\n")
    script = tmp_path / "script.py"
    script.write_text("from init import *\nimport helpers\nhelpers.end(r)\n")
    told = evidence_in(script).against(2)
    assert [line.partition(" is ")[0] for line in told] == [
        "helpers.py line 2: poses",
        "helpers.py line 3: call_at_scripts_end()",
        "init.py line 2: Robotarium(…) with arguments by position",
    ]


OLDER = """\
import rps.robotarium as robotarium
from rps.utilities.transformations import *
from rps.utilities.barrier_certificates import *
N = 5
r = robotarium.Robotarium(number_of_agents=N, save_data=False)
safe = create_single_integrator_barrier_certificate(N)
x = r.get_poses()
dxu = single_integrator_to_unicycle2(safe(dxi, x[:2]), x)
print(r.number_of_agents)
r.call_at_scripts_end()
"""


def test_a_script_of_the_api_before_generation_1_is_recognised():
    found = evidence(OLDER)
    assert found.is_older
    assert found.generation == 1
    told = found.against(1)
    assert [re.search(r"(\S+) (of \w+ )?is of the API of 2017", line)[1] for line in told] == [
        "number_of_agents=",
        "save_data=",
        "number_of_agents=",
        "single_integrator_to_unicycle2",
        "number_of_agents",
    ]
    assert "write number_of_robots=" in told[0]
    assert "leave it out" in told[1]
    assert "generation 1 calls it create_si_to_uni_dynamics" in told[3]
    assert not evidence(OLDER.replace("number_of_agents", "number_of_robots")
                        .replace(", save_data=False", "")
                        .replace("single_integrator_to_unicycle2(", "f(")).is_older  # fmt: skip
