"""Replays recorded calls of the published API against ours, and says where an answer differs.

A case (see :mod:`golden_vectors`) is replayed by the function of its kind in ``KINDS``; it raises
:class:`Differs` with what was expected and what came.

Answers of certificates are compared with the exact optimum of the recorded program. Where that
program has no feasible point, any finite answer of the right shape will do.

Some calls were recorded exactly *at a jump* of the published function: a velocity that points
straight back turns the robot left or right at full rate, a robot at exactly the tolerance has
arrived or not. There the last bit of the recording processor chose, and the other side is as right.
So a recorded answer also counts, robot by robot, if it is ours to arguments that differ from the
recorded ones by `NEAR` in one row: that is so where both lie within `NEAR` of a jump, and nowhere
else (see :func:`from_the_other_side`).
"""

import importlib
import random
import re
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from golden_noise import replay_noise
from golden_vectors import Differs, Vectors, expect, plain, quietly, robotarium

from barrier_certificates.ties import TIE

NO_OPTIMUM = ("infeasible", "doubtful", "not finite")
#: How far arguments are moved to cross a jump: more than the margin that decides on it.
NEAR = 4 * TIE
#: How well the moved answer has to be the recorded one; functions are less steep than this allows.
SIDE = 1e-6


def seed_both(seed: int) -> None:
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002 - what the published code draws from


def names_of(error: BaseException) -> list[str]:
    return [base.__name__ for base in type(error).__mro__]


def function_of(case: dict[str, Any], v: Vectors) -> Any:
    """The function that a case calls, made anew."""
    function = getattr(
        importlib.import_module(case["module"]), case.get("factory") or case["function"]
    )
    if "factory" not in case:
        return function
    arguments = [v.value(argument) for argument in case["factory_args"]]
    function = function(*arguments, **v.value(case["factory_kwargs"]))
    return function if case["returned_index"] is None else function[case["returned_index"]]


def replay_function(case: dict[str, Any], v: Vectors) -> None:
    try:
        with quietly():
            function = function_of(case, v)
    except Exception as error:
        expect(case.get("raises") in names_of(error), "the factory raised", repr(error))
        return
    expect("raises" not in case, "the factory did not raise", case.get("raises"))
    if "seed" in case:
        seed_both(case["seed"])
    for number in range(len(case["calls"])):
        replay_call(case, number, function, v)


def replay_call(case: Any, number: int, function: Any, v: Vectors) -> None:
    call, what = case["calls"][number], f"call {number}"
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
            for index, (written, part) in enumerate(zip(call["returns"], parts, strict=True)):
                try:
                    v.same(written, part, case["rtol"], case["atol"], what)
                except Differs:
                    if not from_the_other_side(case, number, index, part, v):
                        raise
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


def from_the_other_side(case: Any, number: int, index: int, ours: Any, v: Vectors) -> bool:
    """Whether a recorded answer is ours, robot by robot, just beyond a jump.

    Each float argument is moved by ± `NEAR`, a row at a time, all robots alike, and the function is
    asked again, made anew and led through the calls before. Each robot whose answer differs from
    the recorded one must have the recorded one after some such move. Numbers are compared to
    `SIDE`, so no answer is taken for another that is not some jump away.
    """
    call = case["calls"][number]
    recorded, ours = v.value(call["returns"][index]), np.asarray(ours)
    if not isinstance(recorded, np.ndarray) or recorded.shape != ours.shape:
        return False
    missing = ~np.isclose(ours, recorded, case["rtol"], case["atol"], equal_nan=True)
    for arguments in moved(call, v):
        with quietly():
            function = function_of(case, v)
            for earlier in case["calls"][:number]:
                function(*map(v.value, earlier["args"]), **v.value(earlier["kwargs"]))
            answer = function(*arguments, **v.value(call["kwargs"]))
        part = np.asarray(answer[index] if isinstance(answer, tuple | list) else answer)
        if part.shape == recorded.shape:
            agrees = np.isclose(part, recorded, SIDE, SIDE, equal_nan=True)
            missing &= ~agrees.all(axis=tuple(range(agrees.ndim - 1)))
    return not missing.any()


def moved(call: Any, v: Vectors) -> Iterator[list[Any]]:
    """The positional arguments of a call, one row of one of them moved by ± `NEAR`, in turn."""
    for place, written in enumerate(call["args"]):
        shape = np.shape(v.value(written))
        for row in range(shape[0] if len(shape) == 2 else 0):
            for step in (NEAR, -NEAR):
                arguments = [v.value(argument) for argument in call["args"]]
                arguments[place] = np.array(arguments[place], dtype=float)
                arguments[place][row] += step
                yield arguments


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
