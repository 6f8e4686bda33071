"""What ``import rps`` finds when this folder is on PYTHONPATH: generation 2 of rps_compat."""

from _frozen_importlib_external import SourceFileLoader

_arrival = __file__[: -len("generation2/rps/__init__.py")] + "arrival.py"
exec(SourceFileLoader("arrival", _arrival).get_code("arrival"), {"api": 2, "__file__": _arrival})  # type: ignore[arg-type]
