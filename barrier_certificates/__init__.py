"""Safety filters for teams of mobile robots, as small exact quadratic programs.

From the outside in:

- ``single_integrator``, ``unicycle``: the certificates people call (``certificate`` is what they share);
- ``rows`` and the families ``pairs``, ``walls``, ``obstacles``, ``limits``: what must hold, and
  ``rowbook``: all of it for a team; ``disturbance``: wheels that do not do quite what they are told;
- ``projection``: the nearest velocity that satisfies the rows, and policies where there is none;
  ``active_set``: the guess that answers most steps; ``solvers`` and ``solve_*``: who answers the rest;
- ``deadlock``: robots that are safe but stuck; ``guarantee``: what holds in steps, and what does not.

Nothing here knows the Robotarium or a flock. numpy and scipy suffice; other solvers are optional.
"""
