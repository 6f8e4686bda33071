"""Control barrier function (CBF) safety filters for teams of mobile robots, as small exact QPs.

Some function h of where robots are says whether they are safe: ``h ≥ 0``. For two robots that have
to stay r apart, ``h = ‖xᵢ − xⱼ‖² − r²``; for a wall, the distance to it less a margin. Such an h is
a *control barrier function* when velocities can always be chosen with ``ḣ ≥ −γ h³``: far from the
limit robots may close in quickly, near it ever more slowly, and h never turns negative. Because
``ḣ`` is linear in the velocities, each such condition is one linear *row* ``a·v ≤ b``, and so is
each limit of the motors. The safe velocities nearest to the desired ones are the solution of a
quadratic program (QP): ``min ‖v − v̂‖²`` over all rows of the team. That program is solved exactly,
in a fraction of a millisecond for nine robots.

From the outside in:

- `single_integrator`, `unicycle`: the certificates, to be called once a step; `certificate`: what
  both are given and remember; `differential_drive`: what the motors of a unicycle can do;
- `late`: the certificate for robots that answer late; `batch`: a certificate for many teams;
- `projection`: the nearest velocity that satisfies the rows, and what is done where there is none;
- `solvers`: who solves a small program, one module a solver;
- `rows`: what must hold: pairs, walls, obstacles, limits, and how a team's rows lie in arrays;
- `deadlock`: robots that are safe but stuck; `guarantee`: what holds in steps, and what voids it;
- `ties`: what is decided where numbers are equal but for their last bits;
- `certificate_errors`: what is raised, under one root; `checks`: who raises most of it;
- `per_robot`: one number for all robots or one for each; `robot_drive`: the motors of one;
  `given_parameters`: in which form parameters are kept;
- `wall_distance`, `file_lock`: what the packages above share, and nobody here asks for;
  `word_enum`: what all three do.

Public are the modules and packages that ``__all__`` lists, with the names that theirs do; the rest
is nobody else's business. Nothing here knows the Robotarium or a flock. numpy and scipy suffice;
other solvers are optional.

References
----------
Wang, Ames and Egerstedt, Safety barrier certificates for collisions-free multirobot systems, IEEE
Transactions on Robotics 33 (2017); Ames et al., Control barrier functions: theory and applications,
European Control Conference (2019).
"""

__all__ = [
    "batch",
    "certificate",
    "certificate_errors",
    "deadlock",
    "differential_drive",
    "guarantee",
    "hearing",
    "late",
    "projection",
    "rows",
    "single_integrator",
    "solvers",
    "ties",
    "unicycle",
]
