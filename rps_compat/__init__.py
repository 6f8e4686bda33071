"""The Robotarium's Python API, both generations, over one headless simulator.

Its certificates are the control barrier function (CBF) filters of `barrier_certificates`.

::

    import rps_compat
    rps_compat.install(generation=2)          # from now on, `import rps` means us
    from rps.robotarium import Robotarium

``arena`` is the simulator; ``v1`` and ``v2`` are the published names over it; ``session`` says how
instances are built (seed, imperfections, log); ``runner`` runs whole scripts.
"""

from rps_compat.own_imports import leave_current_folder

leave_current_folder()

from rps_compat.install import import_path, install, installed, uninstall  # noqa: E402
from rps_compat.session import Session  # noqa: E402

__all__ = [
    "Session",
    "arena",
    "batch",
    "deviations",
    "errors",
    "import_path",
    "install",
    "installed",
    "late_profiles",
    "lint",
    "profiles",
    "realism",
    "report",
    "run_settings",
    "runner",
    "running",
    "session",
    "testbed",
    "uninstall",
    "v1",
    "v2",
]
