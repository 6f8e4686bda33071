"""What ``import rps`` finds when this folder is on PYTHONPATH: generation 2 of rps_compat."""

from _frozen_importlib_external import SourceFileLoader

_arrival = {"__file__": __file__[: -len("generation2/rps/__init__.py")] + "arrival.py"}
exec(SourceFileLoader("arrival", _arrival["__file__"]).get_code("arrival"), _arrival)  # type: ignore
_arrival["arrive"](2)  # type: ignore[operator]
