"""Replays recorded calls of the published API against ours, and says where an answer differs.

The cases lie in ``tests/golden``: one JSON object a line for each case, its arrays in the ``.npz``
beside it. An array is written as ``"@key"``; tuples, lists, matrices, numpy scalars and numbers
that are not finite have a marker each (see :meth:`Vectors.value`). A case is replayed by the
function of its kind in ``KINDS``; it raises :class:`Differs` with what was expected and what came.

Answers of certificates are compared with the exact optimum of the recorded program. Where that
program has no feasible point, any finite answer of the right shape will do.
"""

import contextlib
import importlib
import io
import json
import random
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np

GOLDEN = Path(__file__).parent / "golden"
NO_OPTIMUM = ("infeasible", "doubtful", "not finite")


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


def seed_both(seed: int) -> None:
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002 - what the published code draws from


def names_of(error: BaseException) -> list[str]:
    return [base.__name__ for base in type(error).__mro__]


def replay_function(case: dict[str, Any], v: Vectors) -> None:
    module = importlib.import_module(case["module"])
    try:
        with quietly():
            function = getattr(module, case.get("factory") or case["function"])
            if "factory" in case:
                arguments = [v.value(argument) for argument in case["factory_args"]]
                function = function(*arguments, **v.value(case["factory_kwargs"]))
                if case["returned_index"] is not None:
                    function = function[case["returned_index"]]
    except Exception as error:
        expect(case.get("raises") in names_of(error), "the factory raised", repr(error))
        return
    expect("raises" not in case, "the factory did not raise", case.get("raises"))
    if "seed" in case:
        seed_both(case["seed"])
    for number, call in enumerate(case["calls"]):
        replay_call(case, call, function, v, f"call {number}")


def replay_call(case: Any, call: Any, function: Any, v: Vectors, what: str) -> None:
    with quietly():
        arguments = [v.value(argument) for argument in call["args"]]
        named = {name: v.value(argument) for name, argument in call["kwargs"].items()}
    handed = {**{str(i): a for i, a in enumerate(arguments)}, **named}
    before = {name: a.copy() for name, a in handed.items() if isinstance(a, np.ndarray)}
    answer, raised = None, None
    with quietly(), warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        # Ours alone, at a first call that is unsafe already; the answer is the recorded one.
        warnings.filterwarnings("ignore", "the first call of a certificate")
        try:
            answer = function(*arguments, **named)
        except Exception as error:
            raised = error
    certificate = case.get("compare") == "barrier"
    if certificate and call.get("qp", {}).get("status") in NO_OPTIMUM:
        if raised is None:
            given = np.asarray(arguments[0])
            finite = np.isfinite(np.asarray(answer, float)).all() or not np.isfinite(given).all()
            expect(np.shape(answer) == given.shape and finite, what, "is not finite")
            return
        if call.get("raises") in names_of(raised):
            return
    if "raises" in call:
        expect(raised is not None, what, "did not raise", call["raises"])
        expect(call["raises"] in names_of(raised), what, "raised", repr(raised))
    else:
        expect(raised is None, what, "raised", repr(raised))
        if case.get("compare") == "outcome_only":
            return
        several = isinstance(answer, tuple | list)
        parts = [] if answer is None else list(answer) if several else [answer]
        expect(len(parts) == len(call["returns"]), what, "returned", len(parts), "values")
        if certificate and "optimum" in call:
            v.same(call["optimum"], np.asarray(parts[0]), 1e-6, case["optimum_atol"], what)
        else:
            for written, part in zip(call["returns"], parts, strict=True):
                v.same(written, part, case["rtol"], case["atol"], what)
        alias = next((i for i, a in enumerate(arguments) if any(p is a for p in parts)), None)
        expect(alias == call.get("returns_is_arg"), what, "returned argument", alias)
        kinds = sorted({w.category.__name__ for w in warned if issubclass(w.category, UserWarning)})
        expect(kinds == call.get("warns", []), what, "warned", kinds)
    for name, old in before.items():
        if name in call.get("mutates", {}):
            v.same(call["mutates"][name], handed[name], 1e-9, 1e-12, f"{what}, argument {name}")
        else:
            unchanged = np.array_equal(old, handed[name], equal_nan=old.dtype.kind == "f")
            expect(unchanged, what, "changed its argument", name)


def replay_random(case: dict[str, Any], v: Vectors) -> None:
    function = getattr(importlib.import_module(case["module"]), case["function"])

    def draw(seed: int) -> Any:
        seed_both(seed)
        with quietly():
            return function(*[v.value(a) for a in case["args"]], **v.value(case["kwargs"]))

    for seed in range(case["trials"]):
        drawn = draw(seed)
        for check in case["checks"]:
            expect(has_property(check, drawn), f"seed {seed}:", check)
    v.same(case["seeded_returns"], draw(0), 1e-12, 1e-14, "seeded draw")


def has_property(check: dict[str, Any], drawn: np.ndarray) -> bool:
    """Whether an array that was drawn at random has what every such array must have."""
    kind, value = check["check"], check.get("value")
    row = drawn[check["row"]] if "row" in check else drawn
    if kind == "shape":
        return list(drawn.shape) == value
    if kind == "dtype":
        return bool(drawn.dtype.name == value)
    if kind == "min_spacing":
        gaps = drawn[:2, :, None] - drawn[:2, None, :]
        apart = np.hypot(*gaps) + 10 * np.eye(drawn.shape[1])
        return bool((apart >= value - 1e-12).all())
    if kind == "bounds":
        return bool((row >= value[0]).all() and (row <= value[1]).all())
    if kind == "values_in":
        return bool((np.abs(row[:, None] - np.asarray(value)).min(axis=1) < 1e-12).all())
    if kind == "columns_unique":
        return bool(np.unique(np.round(drawn, 9), axis=1).shape == drawn.shape)
    if kind == "row_sums":
        return bool(np.allclose(drawn.sum(axis=1), value, rtol=0, atol=1e-12))
    if kind == "symmetric":
        return bool(np.array_equal(drawn, drawn.T))
    if kind == "offdiag_values":
        return bool(np.isin(drawn[~np.eye(len(drawn), dtype=bool)], value).all())
    if kind == "edges":
        return bool(round(-np.tril(drawn, -1).sum()) == value)
    if kind == "connected":
        return bool(np.linalg.matrix_rank(drawn) == len(drawn) - 1)
    raise Differs(f"unknown property {kind}")


def replay_simulation(case: dict[str, Any], v: Vectors) -> None:
    if "seed" in case:
        seed_both(case["seed"])
    readings: dict[str, list[Any]] = {name: [] for name in case.get("sensors", [])}
    poses, schedule, ids = [], dict(case["ids"]), None
    commands = v.array(case["velocities"])
    with quietly():
        r = robotarium(v.value(case["init"]), v.value(case.get("class_overrides", {})))
        if "reseed_after_init" in case:
            np.random.seed(case["reseed_after_init"])  # noqa: NPY002
        for step in range(case["steps"]):
            ids = schedule.get(step, ids)
            read = r.get_poses()
            if step % case.get("pose_stride", 1) == 0:
                poses.append(np.array(read))
            if step % case.get("set_every", 1) == 0:
                command = commands[step // case.get("hold", 1)]
                r.set_velocities(np.array(ids), command[:, ids].copy())
            r.step()
            if step % case.get("sensor_stride", 1) == 0:
                for name, found in readings.items():
                    found.append(np.array(getattr(r, name)()))
        poses.append(np.array(r.get_poses()))
    first = hasattr(r, "velocities")
    ours = {
        "poses": np.array(poses),
        "velocities_after": np.array(r.velocities if first else r._velocities),
        "errors": plain(r._errors),
        "iterations": r._iterations if first else r._iteration,
        **{f"sensor:{name}": np.array(found) for name, found in readings.items()},
    }
    for what, written in case["expect"].items():
        v.same(written, ours[what], case["rtol"], case["atol"], what)


def replay_script(case: dict[str, Any], v: Vectors) -> None:
    held: dict[str, Any] = {}

    def of(written: Any) -> Any:
        return (
            held[written["$var"]]
            if isinstance(written, dict) and "$var" in written
            else (v.value(written))
        )

    def perform(op: dict[str, Any]) -> Any:
        kind = op["op"]
        if kind == "seed":
            return seed_both(op["value"])
        if kind == "let":
            return v.value(op["value"])
        if kind == "new":
            positional = [v.value(argument) for argument in op.get("positional", [])]
            module = importlib.import_module("rps.robotarium")
            return module.Robotarium(*positional, **{k: of(a) for k, a in op["init"].items()})
        if kind == "call":
            return getattr(held[op["on"]], op["method"])(*[of(a) for a in op.get("args", [])])
        if kind == "attr":
            return getattr(held[op["on"]], op["name"])
        if kind == "fill":
            held[op["on"]][...] = op["value"]
            return None
        if kind == "shares":
            return bool(np.shares_memory(held[op["a"]], held[op["b"]]))
        if kind == "same":
            return held[op["a"]] is held[op["b"]]
        assert kind == "value"
        return held[op["on"]]

    for number, op in enumerate(case["ops"]):
        what = f"operation {number} ({op['op']} {op.get('method', op.get('name', ''))})"
        with quietly() as printed:
            try:
                result, raised = perform(op), None
            except Exception as error:
                result, raised = None, error
        if "raises" in op:
            expect(raised is not None, what, "did not raise", op["raises"])
            expect(op["raises"] in names_of(raised), what, "raised", repr(raised))
            if op["op"] == "new":
                return
            continue
        expect(raised is None, what, "raised", repr(raised))
        if "as" in op:
            held[op["as"]] = result
        if "result" in op:
            v.same(op["result"], result, 1e-9, 1e-12, what)
        if "expect_stdout" in op:
            expect(printed.getvalue() == op["expect_stdout"], what, "printed", printed.getvalue())


def replay_attributes(case: dict[str, Any], v: Vectors) -> None:
    with quietly():
        r = robotarium(v.value(case["init"]))
    for name, recorded in case["attributes"].items():
        expect(hasattr(r, name), "there is no", name)
        ours = getattr(r, name)
        kind = type(ours).__name__
        expect(kind == recorded["type"], name, "is a", kind, "not a", recorded["type"])
        if "array" in recorded:
            v.same(recorded["array"], ours, case["rtol"], case["atol"], name)
        elif "len" in recorded:
            expect(len(ours) == recorded["len"], name, "has length", len(ours))
        if "value" in recorded and kind == "float":
            expect(np.isclose(ours, recorded["value"], case["rtol"], case["atol"]), name, ours)
        elif "value" in recorded:
            expect(ours == recorded["value"], name, "is", ours, "not", recorded["value"])
    for method in case["info"]["public_methods"]:
        expect(callable(getattr(r, method, None)), "there is no method", method)


def replay_noise(case: dict[str, Any], v: Vectors) -> None:
    """Means and spreads of all sensors of robots that stand still."""
    names = ("distances", "encoders", "accelerations", "gyros", "magnetic_fields", "orientations")
    series: dict[str, list[Any]] = {name: [] for name in names}
    with quietly():
        r = robotarium(v.value(case["init"]))
        np.random.seed(12345)  # noqa: NPY002
        for _ in range(case["steps"]):
            r.get_poses()
            r.step()
            for name, readings in series.items():
                readings.append(np.array(getattr(r, f"get_{name}")(), float))
    for name, readings in series.items():
        centre, spread, missed = statistics(name, np.array(readings))
        recorded = v.array(case["expect"][name])
        expect(np.array_equal(np.isnan(centre), np.isnan(recorded[0])), name, "missing readings")
        sigma = np.nan_to_num(recorded[1])
        wide = 1.6 if name == "distances" else 1.0
        apart = np.abs(np.nan_to_num(centre - recorded[0]))
        limit = 6 * wide * sigma * np.sqrt(2 / case["steps"]) + 1e-9
        expect((apart <= limit).all(), name, "mean", centre, "not", recorded[0])
        share = 0.25 if name == "encoders" else 0.12
        apart = np.abs(np.nan_to_num(spread) - sigma)
        expect((apart <= share * sigma + 1e-9).all(), name, "spread", spread, "not", sigma)
        if missed is not None:
            rate = recorded[2]
            limit = 6 * np.sqrt(2 * rate * (1 - rate) / case["steps"]) + 1e-9
            expect((np.abs(missed - rate) <= limit).all(), name, "dropouts", missed, "not", rate)


def statistics(name: str, readings: np.ndarray) -> tuple[Any, Any, Any]:
    """Centre, spread and rate of missed readings, each as the vectors have it."""
    if name == "encoders":
        readings = np.diff(readings, axis=0)
    if name == "orientations":  # on a circle
        turned = np.exp(1j * np.deg2rad(readings))
        mean = np.angle(turned.mean(axis=0))
        around = np.angle(turned * np.exp(-1j * mean))
        return np.mod(np.rad2deg(mean), 360), np.rad2deg(around.std(axis=0)), None
    if name == "distances":  # with outliers: median and quartiles
        hit = readings >= 0
        read = np.where(hit, readings, np.nan)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            low, middle, high = np.nanpercentile(read, [25, 50, 75], axis=0)
        return middle, (high - low) / 1.349, 1 - hit.mean(axis=0)
    return readings.mean(axis=0), readings.std(axis=0), None


def replay_initialization(case: dict[str, Any], v: Vectors) -> None:
    recorded = case["expect"]
    if recorded.get("timeout"):
        return
    seed_both(case["seed"])
    target = v.array(recorded["target"])
    with quietly():
        r = robotarium(
            {
                "number_of_robots": case["number_of_robots"],
                "show_figure": False,
                "sim_in_real_time": False,
                "initial_conditions": target.copy(),
            }
        )
    error = r.get_poses() - target
    expect((np.hypot(error[0], error[1]) <= case["position_tolerance"]).all(), "positions")
    turn = np.abs(np.arctan2(np.sin(error[2]), np.cos(error[2])))
    expect((turn <= case["rotation_tolerance"]).all(), "headings")
    expect(r._errors == {}, "errors of the drive:", r._errors)
    expect(r._iteration > 1, "the steps of the drive count")


def replay_regex(case: dict[str, Any], v: Vectors) -> None:
    answer = getattr(importlib.import_module(case["module"]), case["function"])(*case["args"])
    expect(re.match(case["regex"], answer), answer, "does not match", case["regex"])


KINDS = {
    "function": replay_function,
    "random": replay_random,
    "simulation": replay_simulation,
    "script": replay_script,
    "attributes": replay_attributes,
    "noise": replay_noise,
    "initialization": replay_initialization,
    "regex": replay_regex,
}


def replay(case: dict[str, Any], v: Vectors) -> str:
    """Replay one case; what differs, in words, or nothing."""
    try:
        KINDS[case["kind"]](case, v)
    except Differs as error:
        return str(error)
    return ""
