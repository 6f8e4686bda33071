"""Recorded calls of the published API: how they are written down, and when two values are the same.

The cases lie in ``tests/golden``: one JSON object a line for each case, its arrays in the ``.npz``
beside it. An array is written as ``"@key"``; tuples, lists, matrices, numpy scalars and numbers
that are not finite have a marker each (see :meth:`Vectors.value`).
"""

import contextlib
import importlib
import io
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np

GOLDEN = Path(__file__).parent / "golden"


class Differs(AssertionError):  # noqa: N818
    """Our answer is not the recorded one."""


def expect(holds: Any, *message: Any) -> None:
    if not holds:
        raise Differs(" ".join(map(str, message)))


class Vectors:
    """The cases of one generation, and their arrays."""

    def __init__(self, generation: int) -> None:
        self.cases = json.loads((GOLDEN / f"v{generation}.json").read_text())
        with np.load(GOLDEN / f"v{generation}.npz") as file:
            self.arrays = {key: file[key] for key in file.files}

    def array(self, key: str) -> np.ndarray:
        return np.array(self.arrays[key.removeprefix("@")])

    def value(self, written: Any) -> Any:
        """What `written` stands for."""
        if isinstance(written, str) and written.startswith("@"):
            return self.array(written)
        if not isinstance(written, dict):
            return written
        if "$np" in written:
            return np.dtype(written["$np"]).type(written["value"])
        if "$float" in written:
            return float(written["$float"])
        if "$tuple" in written:
            return tuple(self.value(part) for part in written["$tuple"])
        if "$list" in written:
            return [self.value(part) for part in written["$list"]]
        if "$matrix" in written:
            return np.asmatrix(self.array(written["$matrix"]))
        if "$robotarium" in written:
            return robotarium(self.value(written["$robotarium"]))
        return {key: self.value(part) for key, part in written.items()}

    def same(self, written: Any, ours: Any, rtol: float, atol: float, what: str = "") -> None:
        """Raise Differs unless `ours` is what was recorded."""
        if isinstance(written, dict) and not any(key.startswith("$") for key in written):
            expect(isinstance(ours, dict), what, "is no dict")
            expect(json.loads(json.dumps(plain(ours))) == written, what, ours, "not", written)
            return
        recorded = self.value(written)
        if isinstance(recorded, tuple | list):
            expect(isinstance(ours, type(recorded)), what, "is no", type(recorded).__name__)
            parts = next(iter(written.values()))
            expect(len(ours) == len(parts), what, "has length", len(ours))
            for index, (part, our) in enumerate(zip(parts, ours, strict=True)):
                self.same(part, our, rtol, atol, f"{what}[{index}]")
        elif isinstance(recorded, np.ndarray):
            ours = np.asarray(ours) if isinstance(ours, np.ndarray | np.generic) else ours
            expect(isinstance(ours, np.ndarray), what, "is no array but", type(ours).__name__)
            expect(ours.shape == recorded.shape, what, ours.shape, "not", recorded.shape)
            expect(ours.dtype.kind == recorded.dtype.kind, what, ours.dtype, recorded.dtype)
            if recorded.dtype.kind == "f":
                near = np.isclose(ours, recorded, rtol=rtol, atol=atol, equal_nan=True)
                expect(near.all(), what, "differs in", int((~near).sum()), "of", near.size)
            else:
                expect(np.array_equal(ours, recorded), what, "differs")
        elif isinstance(recorded, float | np.floating):
            near = np.isclose(float(ours), float(recorded), rtol=rtol, atol=atol, equal_nan=True)
            expect(near, what, ours, "not", recorded)
        else:
            expect(ours == recorded, what, repr(ours), "not", repr(recorded))


def plain(errors: dict[Any, Any]) -> dict[str, Any]:
    """The counters of an instance with keys that JSON knows."""
    return {
        str(kind): plain(count) if isinstance(count, dict) else count
        for kind, count in errors.items()
    }


@contextlib.contextmanager
def quietly() -> Any:
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()) as printed:
        warnings.simplefilter("ignore")
        yield printed


def robotarium(init: dict[str, Any], overrides: dict[str, Any] | None = None) -> Any:
    kind = importlib.import_module("rps.robotarium").Robotarium
    if overrides:
        kind = type("Robotarium", (kind,), overrides)
    return kind(**init)
