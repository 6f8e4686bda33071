"""What the two generations of the API call things, and which of them a script was written for."""

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

#: Functions of the utilities: generation 1's name → generation 2's; None where there is no like.
FUNCTIONS: dict[str, str | None] = {
    "create_single_integrator_barrier_certificate": "create_si_barrier_certificate",
    "create_single_integrator_barrier_certificate2": "create_si_barrier_certificate",
    "create_single_integrator_barrier_certificate_with_boundary": (
        "create_si_barrier_certificate_with_boundary"
    ),
    "create_unicycle_barrier_certificate": "create_uni_barrier_certificate",
    "create_unicycle_barrier_certificate2": "create_uni_barrier_certificate",
    "create_unicycle_barrier_certificate_with_boundary": (
        "create_uni_barrier_certificate_with_boundary"
    ),
    "create_unicycle_differential_drive_barrier_certificate": "create_uni_barrier_certificate",
    "create_unicycle_differential_drive_barrier_certificate_with_boundary": (
        "create_uni_barrier_certificate_with_boundary"
    ),
    "create_robust_barriers": None,
    "create_clf_unicycle_pose_controller": "create_pose_controller_clf",
    "create_clf_unicycle_position_controller": "create_uni_position_controller",
    "create_hybrid_unicycle_pose_controller": "create_pose_controller_hybrid",
    "create_uni_to_si_dynamics": "create_uni_to_si_mapping",
    "generate_initial_conditions": "generate_random_poses",
    "at_pose": "create_at_pose",
    "at_position": "create_at_position",
    "determine_marker_size": None,
    "cycle_GL": "cycleGL",
}
#: Functions that only generation 2 has.
NEW_FUNCTIONS = frozenset(
    {name for name in FUNCTIONS.values() if name}
    | {
        "create_pose_parking_controller_clf",
        "create_pose_parking_controller_hybrid",
        "generate_initial_poses",
        "generate_random_positions",
        "rotation_matrix",
        "unique_filename",
        "simulate_distance_sensors",
        "simulate_distance_sensors_without_robots",
    }
)
#: Attributes of an instance: generation 1's name → generation 2's.
ATTRIBUTES = {
    "call_at_scripts_end": "debug",
    "time_step": "TIME_STEP",
    "robot_diameter": "ROBOT_DIAMETER",
    "wheel_radius": "WHEEL_RADIUS",
    "base_length": "BASE_LENGTH",
    "max_linear_velocity": "MAX_LINEAR_VELOCITY",
    "max_angular_velocity": "MAX_ANGULAR_VELOCITY",
    "max_wheel_velocity": "MAX_WHEEL_VELOCITY",
    "collision_offset": "COLLISION_OFFSET",
    "collision_diameter": "COLLISION_DIAMETER",
    "boundaries": "BOUNDARIES",
    "axes": "_axes_handle",
    "figure": "_fig",
    "poses": "_poses",
    "velocities": "_velocities",
    "_iterations": "_iteration",
    "sim_in_real_time": "_sim_in_real_time",
    "previous_render_time": "_previous_render_time",
}
#: Attributes and methods that only generation 2 has.
NEW_ATTRIBUTES = frozenset(ATTRIBUTES.values()) | {
    "initialize",
    "get_distances",
    "get_distance_endpoints",
    "get_encoders",
    "get_accelerations",
    "get_gyros",
    "get_magnetic_fields",
    "get_orientations",
    "robot_colormap",
    "_leds",
    "_robot_handle",
}
#: Constructor arguments that only generation 2 has.
NEW_ARGUMENTS = frozenset(
    {
        "skip_initialization",
        "use_distance_sensors",
        "obstacles",
        "show_arena_boundaries",
        "show_distance_endpoints",
        "show_distance_rays",
        "show_obstacles",
        "show_robot_patches",
    }
)
# Attribute names too common outside the Robotarium to tell anything (matplotlib's, a user's own).
_COMMON = {"axes", "figure", "debug", "initialize", "poses", "velocities", "boundaries"}


@dataclass(frozen=True)
class Evidence:
    """What in a script speaks for each generation, as (line, name) pairs."""

    first: tuple[tuple[int, str], ...] = ()
    second: tuple[tuple[int, str], ...] = ()

    @property
    def generation(self) -> Literal[1, 2]:
        """The likelier generation; without evidence 1, for which most scripts were written."""
        return 2 if len(self.second) > len(self.first) else 1

    @property
    def certain(self) -> bool:
        """Whether all evidence, and at least some, speaks for one generation."""
        return bool(self.first) != bool(self.second)


def _name_of(node: ast.expr) -> str:
    """Last part of a dotted name, "" of any other expression."""
    return str(getattr(node, "id", getattr(node, "attr", "")))


@dataclass
class _Collector(ast.NodeVisitor):
    first: list[tuple[int, str]] = field(default_factory=list)
    second: list[tuple[int, str]] = field(default_factory=list)
    # Names that make a Robotarium when called: the class, and subclasses with its constructor.
    makers: set[str] = field(default_factory=lambda: {"Robotarium"})
    kinds: set[str] = field(default_factory=lambda: {"Robotarium"})
    classes: list[bool] = field(default_factory=list)  # around here: is it a Robotarium?

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        is_one = any(_name_of(base) in self.kinds for base in node.bases)
        if is_one:
            self.kinds.add(node.name)
            own = (isinstance(part, ast.FunctionDef) and part.name for part in node.body)
            if "__init__" not in own:
                self.makers.add(node.name)
        self.classes.append(is_one)
        self.generic_visit(node)
        self.classes.pop()

    def _constructor_arguments(self, node: ast.Call) -> list[ast.expr] | None:
        """Positional arguments of the call of Robotarium's constructor; None of another call."""
        name = _name_of(node.func)
        if name in self.makers:
            return node.args
        if name != "__init__" or not isinstance(node.func, ast.Attribute):
            return None
        owner = node.func.value
        if isinstance(owner, ast.Call) and _name_of(owner.func) == "super":
            return node.args if self.classes and self.classes[-1] else None
        return node.args[1:] if _name_of(owner) in self.kinds else None  # Robotarium.__init__(self)

    def _name(self, line: int, name: str) -> None:
        if name in FUNCTIONS:
            self.first.append((line, name))
        elif name in NEW_FUNCTIONS:
            self.second.append((line, name))

    def visit_Name(self, node: ast.Name) -> None:
        self._name(node.lineno, node.id)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        self._name(node.lineno, node.attr)
        if node.attr in ATTRIBUTES and node.attr not in _COMMON:
            self.first.append((node.lineno, node.attr))
        elif node.attr in NEW_ATTRIBUTES and node.attr not in _COMMON:
            self.second.append((node.lineno, node.attr))
        self.generic_visit(node)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        if (node.module or "").startswith("rps"):
            if node.module == "rps.utilities.barrier_certificates2":
                self.first.append((node.lineno, node.module))
            if node.module == "rps.utilities.sensors":
                self.second.append((node.lineno, node.module))
            for alias in node.names:
                self._name(node.lineno, alias.name)

    def visit_Call(self, node: ast.Call) -> None:
        positional = self._constructor_arguments(node)
        if positional is not None:
            # Generation 2 takes keywords only; what `*args` holds is unknown.
            if any(not isinstance(argument, ast.Starred) for argument in positional):
                self.first.append((node.lineno, "Robotarium(positional arguments)"))
            for keyword in node.keywords:
                if keyword.arg in NEW_ARGUMENTS:
                    self.second.append((node.lineno, f"{keyword.arg}="))
        if (
            _name_of(node.func) == "debug"
            and not node.args
            and isinstance(node.func, ast.Attribute)
        ):
            self.second.append((node.lineno, "debug"))
        self.generic_visit(node)


def evidence_in(script: Path) -> Evidence:
    """Read what speaks for either generation in `script` and the modules beside it that it imports.

    Raises
    ------
    OSError
        The script cannot be read.
    SyntaxError
        It is not Python.
    """
    return evidence_of(_own_modules(script))


def evidence_of(trees: Iterable[ast.Module]) -> Evidence:
    """Read what speaks for either generation in syntax `trees`."""
    collector = _Collector()
    for tree in trees:
        collector.visit(tree)
    return Evidence(tuple(collector.first), tuple(collector.second))


def _own_modules(script: Path) -> Iterator[ast.Module]:
    waiting, seen = [script], set()
    while waiting:
        path = waiting.pop()
        if path in seen:
            continue
        seen.add(path)
        try:
            tree = ast.parse(path.read_bytes(), str(path))
        except (SyntaxError, ValueError):
            if path == script:
                raise
            continue
        yield tree
        for node in ast.walk(tree):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module:
                names = [node.module]
            for name in names:
                beside = script.parent / (name.split(".")[0] + ".py")
                if beside.is_file():
                    waiting.append(beside)
