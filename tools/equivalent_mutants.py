"""Mutants that no test can kill, since they change nothing that anyone could see, and why.

Each is the end of a file's path, a part of the line, a part of the change, and the reason.
"""

_SQUARE = "the array is square in these two axes"
_WHOLE = "whole numbers become floats in the arithmetic that follows"
_NOBODY = "nobody meets equality but by rounding, and either answer is right"

EQUIVALENT: list[tuple[str, str, str, str]] = [
    ("law.py", "np.nextafter(0.0, 1.0)", "1.0 to 2.0", "the next float is in the same direction"),
    ("law.py", "agents = np.arange(distance.shape[-1])", "", _SQUARE),
    ("law.py", "remembered = np.asarray(imprint", "without argument dtype", _WHOLE),
    ("steering.py", "along >= self.parameters.clear * lengths", "GtE to Gt", _NOBODY),
    ("judge.py", "robots = 0 if ideal.report is None", "0 to 1", "neither is too many"),
]
