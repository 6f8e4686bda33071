"""Safety filters for teams of mobile robots, as small exact quadratic programs.

From the outside in:

- ``single_integrator``, ``unicycle``: the certificates; ``certificate``: what they share;
- ``rows``: what must hold, in the families ``pairs``, ``walls``, ``obstacles`` and ``limits``;
  ``rowbook``: all of it for a team; ``disturbance``: wheels that do not do quite as they are told;
- ``projection``: the nearest velocity that satisfies the rows, and policies where there is none;
  ``active_set``: the guess that answers most steps; ``solvers``, ``solve_*``: who answers the rest;
- ``deadlock``: robots that are safe but stuck; ``guarantee``: what holds in steps, what voids it;
- ``ties``: what is decided where numbers are equal but for their last bits.

Nothing here knows the Robotarium or a flock. numpy and scipy suffice; other solvers are optional.
"""
