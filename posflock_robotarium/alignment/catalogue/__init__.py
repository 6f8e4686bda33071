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

_ORDER = (
    "recording",
    "gamma",
    "alignment_times",
    "polarisation",
    "motion",
    "standing",
    "wheels",
    "distances",
    "cohesion",
    "connectivity",
    "walls",
    "certificate",
    "confidence",
)
"""Which family comes first in tables and figures; a file that is not named here comes last."""

_found = sorted(module.name for module in iter_modules(__path__))
for _name in [*_ORDER, *(name for name in _found if name not in _ORDER)]:
    import_module(f"{__name__}.{_name}")
