"""Arguments of a generation-2 Robotarium: their defaults, and what is wrong with those given."""

import warnings
from dataclasses import dataclass, fields
from difflib import get_close_matches
from typing import Any

import numpy as np

from rps_compat.errors import ConstructorError


@dataclass
class ConstructorOptions:
    """Arguments of `ARobotarium`, which the published API takes as ``**kwargs``.

    Attributes
    ----------
    number_of_robots : int
        1 to 50; None where it was not given, which is refused.
    show_figure, sim_in_real_time : bool
        Whether the arena is drawn, and whether a step waits.
    initial_conditions : (3, N) array
        Poses, m and rad; empty where they are to be drawn.
    skip_initialization, use_distance_sensors : bool
        Whether robots start there, and have sensors.
    obstacles : (M, 2, 2) array, optional
        Segments that the sensors see, m.
    show_arena_boundaries, show_distance_endpoints, show_distance_rays : bool
        What the figure shows.
    show_obstacles, show_robot_patches : bool
        What else the figure shows.
    """

    number_of_robots: Any = None
    show_figure: Any = True
    sim_in_real_time: Any = True
    initial_conditions: Any = ()
    skip_initialization: Any = False
    use_distance_sensors: Any = False
    obstacles: Any = None
    show_arena_boundaries: Any = True
    show_distance_endpoints: Any = True
    show_distance_rays: Any = False
    show_obstacles: Any = True
    show_robot_patches: Any = True

    @classmethod
    def of(cls, given: dict[str, Any]) -> "ConstructorOptions":
        """Return the options given by name; warn of names that there are not, as published.

        Parameters
        ----------
        given : dict
            What the constructor was called with.
        """
        known = [option.name for option in fields(cls)]
        for name in given.keys() - set(known):
            # As published, an unknown name is no error; silence would hide a typing error.
            near = get_close_matches(name, known, 1)
            hint = f"; did you mean {near[0]}?" if near else ""
            warnings.warn(f"Robotarium ignores the argument {name!r}{hint}", stacklevel=4)
        return cls(**{name: value for name, value in given.items() if name in known})

    def check(self) -> None:
        """Refuse what no Robotarium can be made of.

        Raises
        ------
        ConstructorError
            `number_of_robots` is missing, no int, or not 1 to 50; a switch is not True or False.
        """
        robots = self.number_of_robots
        if robots is None:
            raise ConstructorError("number_of_robots is missing: Robotarium(number_of_robots=9)")
        if not isinstance(robots, int | np.integer) or isinstance(robots, bool):
            raise ConstructorError(
                f"number_of_robots is {robots!r} ({type(robots).__name__}), expected an int"
            )
        if not 1 <= robots <= 50:
            raise ConstructorError(f"number_of_robots is {robots}, expected 1 to 50")
        for option in fields(self):
            value = getattr(self, option.name)
            if isinstance(option.default, bool) and not isinstance(value, bool):
                raise ConstructorError(f"{option.name} is {value!r}, expected True or False")
