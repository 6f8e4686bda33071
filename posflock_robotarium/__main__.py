"""``python -m posflock_robotarium`` is the ``posflock`` command."""

from posflock_robotarium.cli import main

main()
