"""The environment variables of a process of ours in which a script runs that draws for nobody."""

from __future__ import annotations

import os
from pathlib import Path


def script_environment(fonts: Path) -> dict[str, str]:
    """Return this process's environment as one that runs a script is given it.

    Parameters
    ----------
    fonts : Path
        Folder of matplotlib's own, see `caches.lay_font_list`.
    """
    # What measures the tests would write its data where no script may.
    inherited = {k: v for k, v in os.environ.items() if not k.startswith("COVERAGE_")}
    return inherited | {
        "MPLBACKEND": "module://rps_compat.headless_backend",
        "MPLCONFIGDIR": str(fonts),
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
        "PYTHONBREAKPOINT": "0",
    }
