"""What the two generations of the API call things, and which of them a script was written for."""

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
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
    "get_distance_endpoints",
    "robot_colormap",
    "_leds",
    "_robot_handle",
}
#: Functions, methods and arguments that generation 2 and the last release of generation 1 have:
#: they stop no script, and speak for generation 2 only where nothing else speaks.
SENSOR_NAMES = frozenset(
    {
        "get_distances",
        "get_encoders",
        "get_accelerations",
        "get_gyros",
        "get_magnetic_fields",
        "get_orientations",
        "rotation_matrix",
        "use_distance_sensors",
        "obstacles",
    }
)
#: Constructor arguments that only generation 2 has.
NEW_ARGUMENTS = frozenset(
    {
        "skip_initialization",
        "show_arena_boundaries",
        "show_distance_endpoints",
        "show_distance_rays",
        "show_obstacles",
        "show_robot_patches",
    }
)
# Attribute names too common outside the Robotarium to tell anything (matplotlib's, a user's own).
_COMMON = {"axes", "figure", "debug", "initialize", "poses", "velocities", "boundaries"}


# What stands in a clue for a call whose arguments have no names.
_BY_POSITION = "Robotarium(positional arguments)"
#: Exceptions whose handler makes a script ready for a name that is not there.
_MISSING = {
    "AttributeError", "BaseException", "Exception", "ImportError", "ModuleNotFoundError",
    "NameError", "RobotariumError", "TypeError", "WrongGenerationError",
}  # fmt: skip


@dataclass(frozen=True)
class Clue:
    """Something in a script that speaks for one generation.

    Attributes
    ----------
    line
        Where, counted from 1.
    name
        A function, module or attribute, an argument with ``=`` behind it, or the constructor.
    fatal
        Whether the other generation stops there: surely the Robotarium's, and not asked for with
        ``hasattr``, ``getattr`` or ``try``.
    module
        File name of the module beside the script that it stands in; "" for the script itself.
    """

    line: int
    name: str
    fatal: bool = False
    module: str = ""


@dataclass(frozen=True)
class Evidence:
    """What in a script speaks for each generation."""

    first: tuple[Clue, ...] = ()
    second: tuple[Clue, ...] = ()

    @property
    def generation(self) -> Literal[1, 2]:
        """The likelier generation; without evidence 1, for which most scripts were written."""
        second = len(self._second_alone)
        if second or self.first:
            return 2 if second > len(self.first) else 1
        return 2 if self.second else 1

    @property
    def _second_alone(self) -> list[Clue]:
        """What generation 1 has not, not even its last release."""
        return [clue for clue in self.second if clue.name.rstrip("=") not in SENSOR_NAMES]

    @property
    def certain(self) -> bool:
        """Whether all evidence, and at least some, speaks for one generation."""
        return bool(self.first) != bool(self._second_alone if self.first else self.second)

    @property
    def nothing(self) -> bool:
        """Whether nothing speaks for any generation."""
        return not self.first and not self.second

    def against(self, generation: Literal[1, 2]) -> list[str]:
        """Say what stops the script if it runs as `generation`, and what is right there."""
        told = {
            (clue.module, clue.line, clue.name): _told(clue, generation)
            for clue in (self.second if generation == 1 else self.first)
            if clue.fatal
        }
        return [told[key] for key in sorted(told)]


def _told(clue: Clue, generation: Literal[1, 2]) -> str:
    name, running = clue.name, f"generation {3 - generation}'s; running as generation {generation}"
    where = f"{clue.module} line {clue.line}" if clue.module else f"line {clue.line}"
    if name == _BY_POSITION:
        return f"{where}: arguments of Robotarium by position are {running}, which takes names only"
    if name.endswith("="):
        return f"{where}: {name} is {running}, which has no such argument of Robotarium"
    right = _RIGHT[generation].get(name)
    if not right:
        return f"{where}: {name} is {running}, which has nothing like it"
    call = "()" if right in ("debug", "call_at_scripts_end") else ""
    return f"{where}: {name} is {running}, which calls it {right}{call}"


_RIGHT: dict[int, dict[str, str | None]] = {
    1: {new: old for old, new in reversed([*FUNCTIONS.items(), *ATTRIBUTES.items()]) if new},
    2: {**FUNCTIONS, **ATTRIBUTES},
}


def name_of(node: ast.expr) -> str:
    """Last part of a dotted name, "" of any other expression."""
    return str(getattr(node, "id", getattr(node, "attr", "")))


def _calls_super(node: ast.Call) -> bool:
    owner = getattr(node.func, "value", None)
    return (
        name_of(node.func) == "__init__"
        and isinstance(owner, ast.Call)
        and name_of(owner.func) == "super"
    )


class Kinds:
    """Names in one module that are a Robotarium, make one, or hold one."""

    def __init__(self, tree: ast.Module) -> None:
        #: The class and its subclasses.
        self.classes = {"Robotarium"}
        #: What makes one by Robotarium's own constructor.
        self.makers = {"Robotarium"}
        #: Expressions that hold one, as source: ``r``, ``self.r``, ``self`` of a subclass.
        self.instances: set[str] = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef) and self.includes(node):
                self.classes.add(node.name)
                self.instances.add("self")
                own = (isinstance(part, ast.FunctionDef) and part.name for part in node.body)
                if "__init__" not in own:
                    self.makers.add(node.name)
        for node in ast.walk(tree):
            if not isinstance(node, ast.Assign | ast.AnnAssign):
                continue
            if isinstance(node.value, ast.Call) and name_of(node.value.func) in self.classes:
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                self.instances |= {ast.unparse(target) for target in targets}

    def super_calls(self, tree: ast.Module) -> set[ast.Call]:
        """Find the calls ``super().__init__(...)`` that are Robotarium's constructor."""
        return {
            call
            for node in ast.walk(tree)
            if isinstance(node, ast.ClassDef) and self.includes(node)
            for call in ast.walk(node)
            if isinstance(call, ast.Call) and _calls_super(call)
        }

    def includes(self, node: ast.ClassDef) -> bool:
        """Whether the class is a Robotarium."""
        return any(name_of(base) in self.classes for base in node.bases)


class _Collector(ast.NodeVisitor):
    """Clues in one module."""

    def __init__(self, tree: ast.Module, module: str) -> None:
        self.first: list[Clue] = []
        self.second: list[Clue] = []
        self._module, self._kinds = module, Kinds(tree)
        self._probed = _probed(tree)
        self._starred = False
        self._rps: set[str] = set()  # names of the API's modules
        self._guards = 0  # how many `try` are around here
        self._classes: list[bool] = []  # classes around here: is it a Robotarium?
        self._own = {n.name for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)}
        #: Attributes that the script gives to its own subclass.
        self._given = self._own | {
            n.attr
            for n in ast.walk(tree)
            if isinstance(n, ast.Attribute)
            and isinstance(n.ctx, ast.Store)
            and name_of(n.value) == "self"
        }
        self.visit(tree)

    def _found(
        self, generation: Literal[1, 2], node: ast.stmt | ast.expr, name: str, fatal: bool
    ) -> None:
        everywhere = name.rstrip("=") in SENSOR_NAMES
        fatal = fatal and not (everywhere or self._guards or name in self._probed)
        clues = self.first if generation == 1 else self.second
        clues.append(Clue(node.lineno, name, fatal, self._module))

    def _function(self, node: ast.stmt | ast.expr, name: str, fatal: bool) -> None:
        if name in FUNCTIONS:
            self._found(1, node, name, fatal)
        elif name in NEW_FUNCTIONS | {"rotation_matrix"}:
            self._found(2, node, name, fatal)

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        self._classes.append(self._kinds.includes(node))
        self.generic_visit(node)
        self._classes.pop()

    def visit_Try(self, node: ast.Try) -> None:
        ready = any(
            handler.type is None or _MISSING & {name_of(kind) for kind in _parts(handler.type)}
            for handler in node.handlers
        )
        self._guards += ready
        for part in (*node.body, *node.handlers):
            self.visit(part)
        self._guards -= ready
        for part in (*node.orelse, *node.finalbody):
            self.visit(part)

    def visit_Name(self, node: ast.Name) -> None:
        if node.id not in self._own:
            self._function(node, node.id, self._starred and isinstance(node.ctx, ast.Load))

    def visit_Attribute(self, node: ast.Attribute) -> None:
        name, owner = node.attr, ast.unparse(node.value)
        self._function(node, name, owner.split(".")[0] in self._rps)
        known = owner in self._kinds.instances
        if owner == "self":
            known = bool(self._classes and self._classes[-1]) and name not in self._given
        if known or name not in _COMMON:
            if name in ATTRIBUTES:
                self._found(1, node, name, known or name == "call_at_scripts_end")
            elif name in NEW_ATTRIBUTES or (name in SENSOR_NAMES and name.startswith("get_")):
                self._found(2, node, name, known)
        self.generic_visit(node)

    def visit_Import(self, node: ast.Import) -> None:
        for alias in node.names:
            if alias.name.split(".")[0] == "rps":
                self._rps.add(alias.asname or "rps")

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        module = node.module or ""
        if not module.startswith("rps"):
            return
        if module == "rps.utilities.barrier_certificates2":
            self._found(1, node, module, True)
        if module == "rps.utilities.sensors":
            self._found(2, node, module, True)
        for alias in node.names:
            self._starred |= alias.name == "*"
            if module == "rps.utilities":
                self._rps.add(alias.asname or alias.name)
            self._function(node, alias.name, True)

    def visit_Call(self, node: ast.Call) -> None:
        positional = self._constructor_arguments(node)
        if positional is not None:
            # Generation 2 takes keywords only; what `*args` holds is unknown.
            if any(not isinstance(argument, ast.Starred) for argument in positional):
                self._found(1, node, _BY_POSITION, True)
            for keyword in node.keywords:
                if keyword.arg in NEW_ARGUMENTS | SENSOR_NAMES:
                    self._found(2, node, f"{keyword.arg}=", True)
        function = node.func
        if (
            isinstance(function, ast.Attribute)
            and function.attr == "debug"
            and not node.args
            and ast.unparse(function.value) not in self._kinds.instances  # those are found anyway
        ):
            self._found(2, node, "debug", False)
        self.generic_visit(node)

    def _constructor_arguments(self, node: ast.Call) -> list[ast.expr] | None:
        """Positional arguments of the call of Robotarium's constructor; None of another call."""
        name = name_of(node.func)
        if name in self._kinds.makers:
            return node.args
        if _calls_super(node):
            return node.args if self._classes and self._classes[-1] else None
        owner = getattr(node.func, "value", None)
        if name == "__init__" and owner is not None and name_of(owner) in self._kinds.classes:
            return node.args[1:]  # Robotarium.__init__(self, ...)
        return None


def _parts(node: ast.expr) -> list[ast.expr]:
    return node.elts if isinstance(node, ast.Tuple) else [node]


def _probed(tree: ast.Module) -> set[str]:
    """Names that the script asks for before it uses them, and what the other generation says."""
    asked = {
        node.args[1].value
        for node in ast.walk(tree)
        if isinstance(node, ast.Call)
        and name_of(node.func) in ("hasattr", "getattr")
        and len(node.args) > 1
        and isinstance(node.args[1], ast.Constant)
        and isinstance(node.args[1].value, str)
    }
    others = (_RIGHT[generation].get(name) for name in asked for generation in (1, 2))
    return asked | {name for name in others if name}


def evidence_in(script: Path) -> Evidence:
    """Read what speaks for either generation in `script` and the modules beside it that it imports.

    Raises
    ------
    OSError
        The script cannot be read.
    SyntaxError
        It is not Python.
    """
    return _evidence(_own_modules(script))


def evidence_of(trees: Iterable[ast.Module]) -> Evidence:
    """Read what speaks for either generation in syntax `trees`."""
    return _evidence((tree, "") for tree in trees)


def _evidence(modules: Iterable[tuple[ast.Module, str]]) -> Evidence:
    collectors = [_Collector(tree, name) for tree, name in modules]
    return Evidence(
        tuple(clue for collector in collectors for clue in collector.first),
        tuple(clue for collector in collectors for clue in collector.second),
    )


def _own_modules(script: Path) -> Iterator[tuple[ast.Module, str]]:
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
        yield tree, "" if path == script else path.name
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
