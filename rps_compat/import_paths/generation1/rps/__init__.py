"""What ``import rps`` finds when this folder is on PYTHONPATH: generation 1 of rps_compat."""

import sys
from pathlib import Path

try:
    import rps_compat
except ModuleNotFoundError:  # another environment's Python: bring our own sources along
    sys.path.append(str(Path(__file__).parents[4]))
    import rps_compat

rps_compat.install(api=1)
__import__("rps")
