"""Poses among arrays: which is the time, which are the poses, which the commands."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers import parameters
from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.readers.layouts import (
    MATLABS_OWN,
    may_be_poses,
    only_transposed_rolls,
    to_states,
)
from posflock_robotarium.logs.readers.names import (
    COMMAND_NAMES,
    POSE_NAMES,
    STATE_NAMES,
    STEP_NAMES,
    TIME_NAMES,
)
from posflock_robotarium.logs.run import LayoutError

Floats = NDArray[np.float64]


def poses_among(
    arrays: Mapping[str, NDArray[Any]], where: str, options: ReadOptions, kind: str = "arrays"
) -> Found:
    """Find time, poses, commands and what the run says about itself among named arrays.

    Parameters
    ----------
    arrays : mapping of str to (...) arrays
        Arrays of a file, by name.
    where : str
        File (and variable) name for messages.
    options : ReadOptions
        What the user says.
    kind : str
        What the file is, for the report.
    """
    described = arrays.get(parameters.NAME)
    arrays = {name: array for name, array in arrays.items() if name != parameters.NAME}
    notes = [f"{kind} with {', '.join(arrays)}"]
    if options.array is None:
        arrays = _one_for_all_robots(arrays, notes)
    names = _short_names(arrays)
    t = next((_line(arrays[names[n]], where) for n in TIME_NAMES if n in names), None)
    if t is not None and t.size < 2:
        t = None
    dt = next((_scalar(arrays[names[n]]) for n in STEP_NAMES if n in names), None)
    samples = None if t is None else len(t)
    triple = [
        next((names[n] for n in (state, *STATE_NAMES[state]) if n in names), None)
        for state in STATE_NAMES
    ]
    asked = options.array
    commands: Floats | None = None
    if asked is None and all(name is not None for name in triple):
        poses, how = _stack([arrays[str(name)] for name in triple], where, samples)
        notes.append(f"x, y and heading from {', '.join(map(str, triple))}; {how}")
    else:
        name = _pose_array(arrays, names, where, asked, t)
        array = floats(arrays[name], f"{where}: {name}")
        layout, order = _as_matlab_does(name, array, options)
        poses, commands, how = to_states(array, f"{where}: {name}", layout, order, samples=samples)
        if layout != options.layout:
            how = how.replace("as asked", f"as the testbed's MATLAB interface writes {MATLABS_OWN}")
        notes.append(f"poses from {name}, shape {array.shape}, {how}")
    command = next((names[n] for n in COMMAND_NAMES if n in names), None)
    if command is not None and commands is None:
        commands = _command(arrays[command], poses.shape)
        if commands is not None:
            notes.append(f"commands were recorded too: {command}")
    said, promised = _said(described, where)
    if said:
        notes.append("parameters of the run came with the file")
    return Found(
        t,
        poses,
        tuple(notes),
        commands,
        dt,
        intervention=_number_each_step(arrays.get("intervention"), len(poses)),
        clearance=_number_each_step(arrays.get("clearance"), len(poses)),
        status=_word_each_step(arrays.get("status"), len(poses)),
        real_time=_number_each_step(arrays.get("real_time"), len(poses)),
        parameters=said,
        promised=promised,
    )


def _said(described: NDArray[Any] | None, where: str) -> tuple[dict[str, Any], int | None]:
    """Return what the run says about itself, and how many rows it promises."""
    if described is None:
        return {}, None
    said = parameters.from_array(described, f"{where}: {parameters.NAME}")
    return said, parameters.rows_promised(said)


def _one_for_all_robots(
    arrays: Mapping[str, NDArray[Any]], notes: list[str]
) -> dict[str, NDArray[Any]]:
    """Put ``robot1``, ``robot2``, … of one shape together, where no array has a name of poses."""
    names = _short_names(arrays)
    families: dict[str, dict[int, str]] = {}
    for name in arrays:
        if match := _NUMBERED.fullmatch(name):
            families.setdefault(match["family"], {})[int(match["robot"])] = name
    together = dict(arrays)
    if any(name in names for name in POSE_NAMES):
        return together
    for family, members in families.items():
        parts = [arrays[members[robot]] for robot in sorted(members)]
        alike = len(parts) > 1 and len({part.shape for part in parts}) == 1
        if not alike or family in arrays or any(part.dtype.kind not in "fiu" for part in parts):
            continue
        for name in members.values():
            del together[name]
        flat = [
            part.reshape(-1) if part.size == max(part.shape, default=1) else part for part in parts
        ]
        together[family] = np.stack(flat, axis=-1)
        notes.append(f"an array a robot, put together: {', '.join(members.values())}")
    return together


_NUMBERED = re.compile(r"(?P<family>.*?[^\d_])_?(?P<robot>\d+)")


def _short_names(arrays: Mapping[str, NDArray[Any]]) -> dict[str, str]:
    """Return the arrays' names by what they may be called: ``data.poses`` is ``poses``, too."""
    names: dict[str, str] = {}
    tails = [name.rpartition(".")[2].lower() for name in arrays]
    for name, tail in zip(arrays, tails, strict=True):
        if tails.count(tail) == 1:
            names[tail] = name
    return names | {name.lower(): name for name in arrays}


def _as_matlab_does(
    name: str, array: Floats, options: ReadOptions
) -> tuple[str | None, str | None]:
    """Return the layout and order of columns: the testbed's own, where the array has its name."""
    own = name.rpartition(".")[2].lower() == MATLABS_OWN and array.ndim == 2
    if not own or options.layout is not None or options.order is not None:
        return options.layout, options.order
    wide, tall = (count % 5 == 0 for count in (array.shape[1], array.shape[0]))
    if tall and not (wide and only_transposed_rolls(array)):
        return "5N,T", "robot"
    return ("T,5N", "robot") if wide else (None, None)


def codes_of(words: NDArray[np.str_]) -> NDArray[np.uint32]:
    """Return words as rows of code points, for files that hold numbers alone.

    Parameters
    ----------
    words : (T,) array of str
        One word a sample, such as a certificate's status.

    Returns
    -------
    (T, letters) integer array
        Code points, zero after the end of a word.
    """
    letters = np.ascontiguousarray(words)
    return letters.view(np.uint32).reshape(len(letters), -1)


def _number_each_step(array: NDArray[Any] | None, samples: int) -> Floats | None:
    """Return one number a sample (T,), or None where an array is something else."""
    if array is None or array.dtype.kind not in "fiu":
        return None
    if not array.size == max(array.shape, default=0) == samples:
        return None
    return floats(array, "numbers").reshape(-1)


def _word_each_step(array: NDArray[Any] | None, samples: int) -> NDArray[np.str_] | None:
    """Return one word a sample (T,), which may stand as code points; or None."""
    if array is None:
        return None
    if array.dtype.kind == "U" and array.shape == (samples,):
        return array
    if array.dtype.kind not in "fiu" or array.ndim != 2 or len(array) != samples:
        return None
    if not (array.size and ((array >= 0) & (array < 128)).all()):
        return None
    codes = np.ascontiguousarray(array.astype(np.uint32))
    return codes.view(f"U{codes.shape[1]}").reshape(-1)


def _pose_array(
    arrays: Mapping[str, NDArray[Any]],
    names: Mapping[str, str],
    where: str,
    asked: str | None,
    t: Floats | None,
) -> str:
    if asked is not None:
        if asked not in arrays:
            raise LayoutError(f"{where}: no array {asked!r}; there are {', '.join(arrays)}")
        return asked
    likely = [names[n] for n in POSE_NAMES if n in names]
    if len(likely) == 1:
        return likely[0]
    fitting = [
        name
        for name, array in arrays.items()
        if array.ndim in (2, 3)
        and array.dtype.kind in "fiu"
        and may_be_poses(array.shape, None if t is None else len(t))
        and array.size >= 6
        and min(array.shape) >= 1
        and array.size != max(array.shape)
        and (t is None or len(t) in array.shape)
    ]
    if len(fitting) == 1:
        return fitting[0]
    shown = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
    raise LayoutError(
        f"{where}: {'several arrays' if fitting else 'no array'} could hold the poses: {shown}; "
        "name the one with --array"
    )


def _stack(parts: list[NDArray[Any]], where: str, samples: int | None) -> tuple[Floats, str]:
    """Put x, y and θ of shape (T, N), (N, T) or (T,) together."""
    states = [floats(part, where) for part in parts]
    if len({state.shape for state in states}) != 1 or states[0].ndim not in (1, 2):
        raise LayoutError(f"{where}: x, y and heading have shapes {[s.shape for s in states]}")
    stacked = np.stack(states)
    if stacked.ndim == 2:
        return stacked.T[:, :, np.newaxis], "one robot"
    _, first, second = stacked.shape
    if samples is None:
        samples = max(first, second)
    if first == second or samples not in (first, second):
        raise LayoutError(
            f"{where}: x, y and heading of shape {(first, second)} and {samples} times: "
            "which axis is time? Stack them into one array (T, 3, N)"
        )
    if first == samples:
        return stacked.transpose(1, 0, 2), f"shape (T, N) with {second} robots"
    return stacked.transpose(2, 0, 1), f"shape (N, T) with {first} robots"


def _command(array: NDArray[Any], shape: tuple[int, ...]) -> Floats | None:
    samples, _, robots = shape
    if array.dtype.kind not in "fiu":
        return None
    if array.shape == (samples, 2, robots):
        return np.asarray(array, dtype=np.float64)
    if array.shape == (2, robots, samples):
        return np.asarray(array.transpose(2, 0, 1), dtype=np.float64)
    return None


def _line(array: NDArray[Any], where: str) -> Floats:
    values = floats(array, where)
    if values.size != max(values.shape, default=1):
        raise LayoutError(f"{where}: time has shape {values.shape}, expected one number a sample")
    return values.reshape(-1)


def _scalar(array: NDArray[Any]) -> float | None:
    if array.size == 1 and array.dtype.kind in "fiu":
        value = float(array.reshape(-1)[0])
        return value if np.isfinite(value) and value > 0 else None
    return None


def floats(array: NDArray[Any], where: str) -> Floats:
    """Return real numbers as floats; refuse anything else.

    Parameters
    ----------
    array : (...) array
        Numbers of any kind.
    where : str
        File (and variable) name for messages.

    Returns
    -------
    (...) array
        The numbers as floats.

    Raises
    ------
    LogError
        When they are not real numbers.
    """
    if array.dtype.kind not in "fiu":
        raise LogError(f"{where}: holds {array.dtype}, expected real numbers")
    with np.errstate(all="ignore"):  # what does not fit becomes NaN or infinite, and is refused
        return np.asarray(array, dtype=np.float64)
