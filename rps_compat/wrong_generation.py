"""Names of one generation asked of the other: answered at once, and with the right name."""

from typing import Any, NoReturn

from rps_compat.errors import WrongGenerationError

#: What generation 1 calls it → what generation 2 calls it.
RENAMED = {
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
_BACK = {new: old for old, new in RENAMED.items()}


def refuse(instance: Any, name: str, generation: int) -> NoReturn:
    """Raise for a missing attribute `name`, with the right name where the other generation has one.

    Raises
    ------
    WrongGenerationError
        `name` belongs to the other generation.
    AttributeError
        `name` belongs to neither.
    """
    kind = type(instance).__name__
    right = (_BACK if generation == 1 else RENAMED).get(name)
    if right is None:
        raise AttributeError(f"{kind!r} object has no attribute {name!r}")
    call = "()" if name in ("call_at_scripts_end", "debug") else ""
    raise WrongGenerationError(
        f"{kind!r} object has no attribute {name!r}: that is the name in generation "
        f"{3 - generation} of the API; generation {generation} calls this {right}{call}"
    )
