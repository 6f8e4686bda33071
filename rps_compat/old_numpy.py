"""Names that numpy has dropped, given back while an old script runs.

Most public Robotarium scripts were written for numpy 1; ``np.mat`` and ``np.float`` alone stop many
of them on numpy 2. While a script runs it finds these names, with the meaning that they had.
``posflock lint`` lists them, because the testbed has numpy 2 and does not give them back.
"""

import contextlib
from collections.abc import Iterator

import numpy as np

from rps_compat.versions import NUMPY_GONE

#: Names that were Python's own types.
_BUILTINS = {"float": float, "int": int, "complex": complex, "object": object, "str": str}


@contextlib.contextmanager
def old_numpy_names() -> Iterator[None]:
    """Let ``np`` have its old names within the ``with`` block."""
    given = []
    for old, new in NUMPY_GONE.items():
        if old in vars(np) or (new is None and old not in _BUILTINS):
            continue
        setattr(np, old, _BUILTINS.get(old, getattr(np, new or old, None)))
        given.append(old)
    try:
        yield
    finally:
        for old in given:
            delattr(np, old)
