"""Robots in the processes that a script starts: they belong to its run.

A script may make its robots in a pool, in processes that it forks or that Python starts afresh
(which is usual on Windows and macOS), or in another script that it calls. Each such child

- finds ``rps`` of the right generation, and the run's conditions: seed, imperfections, how robots
  come to their initial conditions, no window (:mod:`~.plan`);
- has a name, and from it logs and random numbers of its own (:mod:`~.names`);
- keeps a record of every instance (:mod:`~.records`), from which the run's report is made when the
  script has ended, whatever became of the child.

:class:`~.family.Family` is what ties them together: a forked child finds it in its memory, one
that is started afresh makes its own when it imports ``rps``.
"""

#: The environment's variable that tells a process that was started afresh of its run.
VARIABLE = "RPS_COMPAT_RUN"
