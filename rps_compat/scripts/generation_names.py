"""What the generations of the API call things: the one table of their names.

Generation 1 is the API of October 2019 to April 2026, of GRITSBot robots. Generation 2, of GTernal
robots, is what the testbed runs since. The API of 2017 to 2019 is called generation 0 here: no
simulator runs it any more, but scripts of it are about, and are told what to change.

Which functions and parameters a generation has is not written here: :mod:`rps_compat.v1` and
:mod:`rps_compat.v2` have them. Here stands what cannot be read off those: what became of what, and
the attributes of an instance.
"""

from __future__ import annotations

#: The class that every script makes.
ROBOTARIUM = "rps.robotarium.Robotarium"

#: Functions and classes: generation 1's name → generation 2's; None where it has nothing like it.
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
    "RobotariumABC": "ARobotarium",
}
#: Functions and classes that only generation 2 has, and that take the place of none.
NEW_FUNCTIONS = frozenset(
    {
        "create_pose_parking_controller_clf",
        "create_pose_parking_controller_hybrid",
        "generate_initial_poses",
        "generate_random_positions",
        "unique_filename",
        "simulate_distance_sensors",
        "simulate_distance_sensors_without_robots",
        "gternal_patch",
        "GTERNALRobotPatch",
        "GTERNALPatchData",
    }
)
#: Modules of one generation only → the generation, and what the other has instead.
MODULES: dict[str, tuple[int, str | None]] = {
    "rps.utilities.barrier_certificates2": (1, "rps.utilities.barrier_certificates"),
    "rps.utilities.sensors": (2, None),
    "rps.patch_creation": (2, None),
    "rps.patch_creation.gternal_patch": (2, None),
}

#: Attributes of an instance: generation 1's name → generation 2's; None: it has none like it.
ATTRIBUTES: dict[str, str | None] = {
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
    "initial_conditions": None,
    "robot_length": None,
    "robot_width": None,
    "robot_radius": None,
    "file_path": None,
    "current_file_size": None,
    "base_patches": None,
    "boundary_patch": None,
    "chassis_patches": None,
    "left_led_commands": None,
    "right_led_commands": None,
    "left_led_patches": None,
    "right_led_patches": None,
    "left_wheel_patches": None,
    "right_wheel_patches": None,
}
#: Attributes and methods that only generation 2 has, and that take the place of none.
NEW_ATTRIBUTES = frozenset(
    {
        "initialize", "initializing", "robot_colormap", "get_distance_endpoints",
        "simulate_accelerations", "simulate_encoder_readings", "simulate_gyros",
        "simulate_magnetometers", "simulate_orientations",
        "show_arena_boundaries", "show_distance_endpoints", "show_distance_rays",
        "show_obstacles", "show_robot_patches",
        "_accelerations", "_calculate_endpoints", "_cm", "_distance_endpoint_patches",
        "_distance_endpoints", "_distance_ray_lines", "_distance_sensors_enabled", "_distances",
        "_draw_distance_endpoints", "_draw_distance_rays", "_draw_robots", "_encoders", "_gyros",
        "_initial_encoders", "_initialize_visualization", "_leds", "_magnetic_fields",
        "_orientations", "_robot_handle", "_velocities_old",
        "ACCELEROMETER_NOISE_STDS", "CENTER_OFFSET", "DISTANCE_SENSORS_ORIENTATION",
        "DISTANCE_SENSOR_DROPOUT_PROB", "DISTANCE_SENSOR_ERROR", "DISTANCE_SENSOR_OUTLIER_PROB",
        "DISTANCE_SENSOR_RANGE", "ENCODER_COUNTS_PER_REVOLUTION", "ENCODER_NOISE_STD",
        "GYRO_NOISE_STDS", "IMU_ORIENTATION", "MAGNETOMETER_NOISE_STDS", "MAGNETOMETER_XY_AVG",
        "MAGNETOMETER_Z_AVG", "MOTOR_GEAR_RATIO", "ORIENTATION_NOISE_STD",
    }
)  # fmt: skip
#: Attributes of other shape in generation 2, which no renaming mends.
OTHER_SHAPE = {
    "boundaries": "generation 2 has (x_min, x_max, y_min, y_max) where generation 1 has "
    "(x, y, width, height)"
}
#: Attributes that nothing but a Robotarium has: they tell one whatever it is called.
UNMISTAKABLE = frozenset({"call_at_scripts_end"})
#: Methods among the attributes: they are told of with their parentheses.
METHODS = frozenset({"call_at_scripts_end", "debug"})

#: Arguments of the constructor in generation 1, in order; generation 2 takes them by name only.
CONSTRUCTOR = ("number_of_robots", "show_figure", "sim_in_real_time", "initial_conditions")
#: Arguments of the constructor that only generation 2 has.
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
#: Parameters that both generations have under different names: function of generation 2 → names.
RENAMED_PARAMETERS = {
    "create_uni_barrier_certificate": {"magnitude_limit": "velocity_magnitude_limit"},
    "create_uni_barrier_certificate_with_boundary": {"magnitude_limit": "velocity_magnitude_limit"},
}

#: Functions of generation 1 that do at once what generation 2 makes a function for → how many of
#: their first arguments go to the function that is made.
MADE_FIRST = {"at_pose": 2, "at_position": 2}
#: Functions of which generation 2 returns two where generation 1 returns the first of them.
FIRST_OF_TWO = frozenset({"create_uni_to_si_dynamics", "unicycle_to_single_integrator"})

#: Functions of generation 0 → their module, and the name in generation 1.
OLD_FUNCTIONS = {
    "single_integrator_position_controller": ("controllers", "create_si_position_controller"),
    "unicycle_pose_controller": ("controllers", "create_hybrid_unicycle_pose_controller"),
    "create_single_integrator_to_unicycle": ("transformations", "create_si_to_uni_mapping"),
    "single_integrator_to_unicycle2": ("transformations", "create_si_to_uni_dynamics"),
    "unicycle_to_single_integrator": ("transformations", "create_uni_to_si_dynamics"),
}
#: Those among them that did at once what later ones make a function for, of two arguments → the
#: options that both have under the same names.
OLD_AT_ONCE: dict[str, tuple[str, ...]] = {
    "single_integrator_position_controller": (),
    "unicycle_pose_controller": (),
    "single_integrator_to_unicycle2": ("linear_velocity_gain", "angular_velocity_limit"),
    "unicycle_to_single_integrator": ("projection_distance",),
}
#: Functions whose first argument was the number of robots in generation 0, and is not any more.
OLD_COUNTED = frozenset(
    {"create_single_integrator_barrier_certificate", "create_unicycle_barrier_certificate"}
)
#: Attributes of an instance of generation 0 → generation 1's name; None: it has none like it.
OLD_ATTRIBUTES: dict[str, str | None] = {
    "number_of_agents": "number_of_robots",
    "boundary": "boundaries",
    "robot_size": "robot_radius",
    "save_data": None,
    "saved_poses": None,
    "saved_velocities": None,
    "update_time": None,
    "arrow_patches": None,
    "circle_patches": None,
    "led_commands": None,
}
#: Arguments of the constructor of generation 0, in order.
OLD_CONSTRUCTOR = ("number_of_agents", "show_figure", "save_data", "update_time")
#: Arguments of the constructor of generation 0 → generation 1's name; None: leave it out.
OLD_ARGUMENTS: dict[str, str | None] = {
    "number_of_agents": "number_of_robots",
    "save_data": None,
    "update_time": None,
}


def counterpart(name: str, generation: int) -> str | None:
    """Return what `generation` calls the function or attribute `name` of another generation.

    Parameters
    ----------
    name : str
        Of any generation.
    generation : int
        1 or 2.
    """
    first = OLD_FUNCTIONS[name][1] if name in OLD_FUNCTIONS else OLD_ATTRIBUTES.get(name) or name
    if generation == 2:
        return _SECOND_OF.get(first, None if first == name else first)
    return _FIRST_OF.get(name, None if first == name else first)


_SECOND_OF = {**FUNCTIONS, **ATTRIBUTES}
_FIRST_OF = {
    new: old for old, new in reversed([*FUNCTIONS.items(), *ATTRIBUTES.items()]) if new is not None
}
