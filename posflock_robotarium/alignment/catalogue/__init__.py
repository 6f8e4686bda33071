"""Every metric that the report knows, one file a family; importing this registers them all.

A new metric is one more entry in one of these files, or one more file beside them: it is found by
itself. Outside of this package, `register` an entry before the run is analysed.

>>> from posflock_robotarium.alignment.catalogue import metrics
>>> metrics()["speed"].unit
'm/s'
"""

from importlib import import_module
from pkgutil import iter_modules

from posflock_robotarium.alignment.metric_registry import (
    Metric,
    Number,
    Scalar,
    figures,
    forget,
    metrics,
    panels,
    register,
    scalars,
)
from posflock_robotarium.alignment.panels import Line, Panel

# In the order of tables and figures: a family registers its metrics when it is imported.
# isort: off
from posflock_robotarium.alignment.catalogue import (  # noqa: F401
    recording,
    gamma,
    alignment_times,
    polarisation,
    motion,
    standing,
    wheels,
    distances,
    cohesion,
    connectivity,
    formation,
    coverage,
    walls,
    certificate,
    confidence,
    gamma_bands,
    sightings,
)
# isort: on

__all__ = [
    "Line",
    "Metric",
    "Number",
    "Panel",
    "Scalar",
    "figures",
    "forget",
    "metrics",
    "panels",
    "register",
    "scalars",
]


def load_families() -> None:
    """Import every file of this folder, those last that are not named above."""
    for name in sorted(module.name for module in iter_modules(__path__)):
        import_module(f"{__name__}.{name}")


load_families()
