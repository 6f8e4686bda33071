"""``python -m posflock_robotarium`` is the ``posflock`` command."""

import rps_compat  # noqa: F401 - first: it takes the user's folder off the path
from posflock_robotarium.cli import main

main()
