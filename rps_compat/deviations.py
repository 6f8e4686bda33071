"""Where this package deliberately answers differently from the published simulators.

The published code has defects that hurt the people who meet them: an answer of NaN, a limit that is
ignored, a caller's array that is changed. There, our answer is the right one. The testbed runs the
published code, though, so a rehearsal may want it faithful to the letter::

    from rps_compat import deviations

    with deviations.all_as_published():
        ...                                # bug for bug

or set the environment variable ``RPS_COMPAT_AS_PUBLISHED=1`` before Python starts. Every deviation
stands in :data:`DEVIATIONS`, and nothing deviates that does not stand there.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass


@dataclass(frozen=True)
class Deviation:
    """One defect: in which functions, what is published, and what we do.

    Attributes
    ----------
    generation : int
        Of the API: 1 or 2.
    functions : tuple of str
        Published names of the functions that have it.
    published : str
        What the published simulator answers.
    ours : str
        What this package answers.
    always : bool
        Whether ours stands even where everything else is wanted as published.
    """

    generation: int
    functions: tuple[str, ...]
    published: str
    ours: str
    always: bool = False


DEVIATIONS: dict[str, Deviation] = {
    "pose controller at angle zero": Deviation(
        1,
        ("create_clf_unicycle_pose_controller",),
        "a robot that looks exactly at its goal, or stands on it, gets the turn rate NaN (0/0)",
        "the limit of the formula, a finite turn rate",
    ),
    "at_position": Deviation(
        1,
        ("at_position",),
        "every call with well-formed arguments raises NameError",
        "who is at their points, as documented",
    ),
    "certificates change their input": Deviation(
        1,
        (
            "create_single_integrator_barrier_certificate",
            "create_single_integrator_barrier_certificate_with_boundary",
            "create_single_integrator_barrier_certificate2",
        ),
        "the caller's velocities are scaled to magnitude_limit in place",
        "the caller's array stays as it is; the answer is the same",
    ),
    "magnitude_limit of unicycle certificates": Deviation(
        1,
        (
            "create_unicycle_barrier_certificate",
            "create_unicycle_barrier_certificate_with_boundary",
            "create_unicycle_barrier_certificate2",
        ),
        "magnitude_limit is ignored, and 0.2 m/s taken",
        "magnitude_limit is obeyed",
    ),
    "differential drive without boundary": Deviation(
        1,
        ("create_unicycle_differential_drive_barrier_certificate",),
        "every call raises NameError",
        "the certificate with boundary, without the boundary",
    ),
    "speed limit towards +x": Deviation(
        2,
        ("create_si_barrier_certificate", "create_uni_barrier_certificate"),
        "the side at +x of the octagon of velocities stands at the limit, not at limit cos(pi/8), "
        "so robots may be asked for 4.6 % more than the limit",
        "a regular octagon within the limit, as in the certificates with boundary",
    ),
    "certificate of a single robot": Deviation(
        2,
        (
            "create_si_barrier_certificate",
            "create_si_barrier_certificate_with_boundary",
            "create_uni_barrier_certificate",
            "create_uni_barrier_certificate_with_boundary",
        ),
        "the command of a single robot comes back as it is: no walls, no speed limit",
        "walls, limits and obstacles hold for one robot as for many",
    ),
    "obstacles": Deviation(
        2,
        ("create_uni_barrier_certificate_with_boundary",),
        "obstacles are free to move in the quadratic program, so they give way and are hit",
        "obstacles stand still, and robots keep their distance",
    ),
    "wrong shapes": Deviation(
        2,
        (
            "create_si_barrier_certificate",
            "create_si_barrier_certificate_with_boundary",
            "create_pose_controller_hybrid",
        ),
        "arrays with a row too many or too few stop all robots with a warning about the solver; "
        "surplus columns of positions or goals are left unread",
        "ShapeError, with what was got and what was expected",
        always=True,
    ),
    "projection point on the axle": Deviation(
        1,
        (
            "create_unicycle_differential_drive_barrier_certificate",
            "create_unicycle_differential_drive_barrier_certificate_with_boundary",
            "create_robust_barriers",
        ),
        "projection_distance=0 is taken, and gives commands from a singular program",
        "NumberError: that point cannot move sideways",
        always=True,
    ),
    "velocity straight back": Deviation(
        1,
        ("create_si_to_uni_dynamics", "create_si_to_uni_dynamics_with_backwards_motion"),
        "whether a robot turns left or right, told to go exactly backwards, is decided by the last "
        "bit of a sine, so by the processor",
        "it turns back through the heading 0: right where its heading is positive, else left",
        always=True,
    ),
    "velocity straight behind": Deviation(
        2,
        ("create_si_to_uni_dynamics",),
        "the same, decided by the last bit of a matrix product",
        "it turns back through the heading 0: right where its heading is positive, else left",
        always=True,
    ),
    "constructor": Deviation(
        2,
        ("Robotarium",),
        "no robots at all, and initial conditions of another number of robots or rows, are "
        "accepted; integer ones crash in the first step; more than 22 robots crash",
        "ConstructorError or InitialConditionsError with what was got and what was expected; "
        "integers and up to 50 robots work",
        always=True,
    ),
    "starts drawn 0.2 m apart": Deviation(
        1,
        ("Robotarium",),
        "without initial_conditions, large teams find no places 0.2 m apart, and crash",
        "they are drawn from a grid, at least 0.26 m apart; others as published",
        always=True,
    ),
    "starts drawn 0.5 m apart": Deviation(
        2,
        ("Robotarium",),
        "without initial_conditions, large teams find no places 0.5 m apart, and crash",
        "the spacing shrinks until they fit, at least 0.26 m apart; others as published",
        always=True,
    ),
    "impossible commands": Deviation(
        2,
        ("set_velocities",),
        "NaN and infinite velocities are accepted, and the run counts as clean",
        "CommandError with the robot and the value (in generation 1 as well)",
        always=True,
    ),
    "counters of one instance": Deviation(
        1,
        ("step", "call_at_scripts_end"),
        "a later instance starts with the violations that the earlier ones counted",
        "each instance has its own",
        always=True,
    ),
    "report": Deviation(
        2,
        ("debug",),
        "actuator warnings vanish where there are hard errors; pairs too close are reported as "
        "time steps",
        "everything is reported, in time steps, with robots, times and distances",
        always=True,
    ),
}

_as_published = os.environ.get("RPS_COMPAT_AS_PUBLISHED", "") not in ("", "0")


def as_published(name: str) -> bool:
    """Whether the deviation `name` is switched off, so that the published defect is wanted.

    Parameters
    ----------
    name : str
        Key of `DEVIATIONS`.
    """
    return _as_published and not DEVIATIONS[name].always


@contextmanager
def all_as_published(wanted: bool = True) -> Iterator[None]:
    """Within the block, answer as the published simulators do, defects included.

    Parameters
    ----------
    wanted : bool
        False has the defects repaired again, within such a block.
    """
    global _as_published
    before, _as_published = _as_published, wanted
    try:
        yield
    finally:
        _as_published = before
