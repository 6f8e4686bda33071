"""Realism profiles as TOML files: the named ones, reading, checking, writing.

A profile is a file to copy and edit. One table an effect, one key a parameter; an effect that is
left out is off, and a key that no effect knows is refused rather than ignored.

.. code-block:: toml

    name = "our lab"
    about = "Fitted to the run of 3 May."

    [dead_time]
    seconds = 0.195                           # the same for every robot

    [gains]
    speed = { uniform = [0.98, 1.03] }        # drawn per robot and run
    turn = { robots = [0.97, 1.01, 0.99] }    # one value a robot
    by_speed = [[0.05, 0.94], [0.1, 1.0]]     # a further factor at |v|, m/s

    [turn_bias]
    rate = { normal = [0.0, 0.010], limit = 0.017 }
"""

from __future__ import annotations

import sys
import typing
from collections.abc import Mapping
from dataclasses import MISSING, fields
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from rps_compat.bounded_files import read_bounded
from rps_compat.distributions import (
    Curve,
    DistributionKind,
    ProfileError,
    RobotDistribution,
    constant,
)
from rps_compat.realism import EFFECTS, Profile

#: Profiles that come with the package, mildest first.
NAMES = ("ideal", "gritsbot_x", "gternal", "harsh")
#: Those of the robots that each generation of the testbed has.
OF_GENERATION = {1: "gritsbot_x", 2: "gternal"}
#: Beyond this no entry of a profile means anything; in SI units, as all are.
LARGEST = 1e6
#: Distributions that are told by name; a constant is told by its number alone.
_NAMED = tuple(kind for kind in DistributionKind if kind is not DistributionKind.CONSTANT)


def load_profile(name: str | Path) -> Profile:
    """Return a profile by name (one of `NAMES`) or from a TOML file.

    Parameters
    ----------
    name : str or Path
        Name of a profile, or a TOML file.

    Raises
    ------
    ProfileError
        Where there is no such profile or file, or it holds what no effect knows.
    """
    if str(name) in NAMES:
        return profile_from_toml(profile_text(str(name)), str(name))
    path = Path(name)
    if path.suffix != ".toml":
        raise ProfileError(
            f"no realism profile is called {str(name)!r}; there are {', '.join(NAMES)},"
            " or give a path that ends in .toml"
        )
    try:
        text = read_bounded(path).decode("utf-8")
    except OSError as error:
        reason = error.strerror or error
        raise ProfileError(f"{path}: cannot be read as a profile ({reason})") from error
    except UnicodeDecodeError as error:
        raise ProfileError(f"{path}: cannot be read as a profile ({error})") from error
    return profile_from_toml(text, str(path))


def chosen_profile(wanted: Profile | str | Path | None, generation: int) -> Profile:
    """Return the profile that somebody wants, or that of the robots of a generation.

    Parameters
    ----------
    wanted : Profile, name, path or None
        As for `load_profile`; None leaves it to the generation.
    generation : int
        Of the testbed: 1 or 2.

    Raises
    ------
    ProfileError
        Where the profile is not one, or there is no such generation.
    """
    if isinstance(wanted, Profile):
        return wanted
    if wanted is not None:
        return load_profile(wanted)
    if generation not in OF_GENERATION:
        raise ProfileError(f"generation: expected 1 or 2, got {generation}")
    return load_profile(OF_GENERATION[generation])


def profile_text(name: str) -> str:
    """Return the TOML text of a named profile, for a user to copy and edit.

    Parameters
    ----------
    name : str
        One of `NAMES`.
    """
    return (resources.files("rps_compat") / "profiles" / f"{name}.toml").read_text("utf-8")


def profile_from_toml(text: str, where: str = "profile") -> Profile:
    """Return the profile that a TOML text describes.

    Parameters
    ----------
    text : str
        Entries ``name`` and ``about``, and a table for each effect.
    where : str
        What errors call it.

    Raises
    ------
    ProfileError
        If it is not TOML, or holds what no effect knows.
    """
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib

    try:
        table = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise ProfileError(f"{where}: not valid TOML: {error}") from error
    return profile_from_dict(table, where)


def profile_from_dict(table: Mapping[str, Any], where: str = "profile") -> Profile:
    """Return the profile that a table of tables describes, as TOML or JSON gives it.

    Parameters
    ----------
    table : mapping
        From effect to its entries, and ``name`` and ``about``.
    where : str
        What errors call it.

    Raises
    ------
    ProfileError
        If it holds what no effect knows.
    """
    _refuse_unknown(table, ("name", "about", *EFFECTS), where)
    values: dict[str, Any] = {"name": str(table.get("name", where)), "about": ""}
    values["about"] = str(table.get("about", ""))
    for effect in EFFECTS:
        if effect in table:
            values[effect] = _effect(effect, table[effect], where)
    return Profile(**values)


def profile_to_dict(profile: Profile) -> dict[str, Any]:
    """Return the table of tables that :func:`profile_from_dict` reads back.

    Parameters
    ----------
    profile : Profile
        What is written.
    """
    out: dict[str, Any] = {"name": profile.name, "about": profile.about}
    for effect in profile.effects:
        settings = getattr(profile, effect)
        out[effect] = {
            entry.name: _plain(getattr(settings, entry.name))
            for entry in fields(settings)
            if entry.default is MISSING or getattr(settings, entry.name) != entry.default
        }
    return out


def profile_to_toml(profile: Profile) -> str:
    """Return `profile` as TOML text that :func:`profile_from_toml` reads back unchanged.

    Parameters
    ----------
    profile : Profile
        What is written.
    """
    table = profile_to_dict(profile)
    lines = [f"{key} = {_toml(table.pop(key))}" for key in ("name", "about")]
    for effect, settings in table.items():
        lines += ["", f"[{effect}]"]
        lines += [f"{key} = {_toml(value)}" for key, value in settings.items()]
    return "\n".join(lines) + "\n"


@cache
def _settings(effect: str) -> tuple[type, dict[str, type]]:
    """Return an effect's class and the types of its parameters."""
    union = typing.get_type_hints(Profile)[effect]
    kind = next(option for option in typing.get_args(union) if option is not type(None))
    return kind, typing.get_type_hints(kind)


def _effect(effect: str, table: Any, where: str) -> Any:
    kind, types = _settings(effect)
    if not isinstance(table, Mapping):
        raise ProfileError(f"{where}: {effect}: expected a table [{effect}], got {table!r}")
    _refuse_unknown(table, tuple(types), f"{where}: [{effect}]")
    missing = [f.name for f in fields(kind) if f.default is MISSING and f.name not in table]
    if missing:
        raise ProfileError(f"{where}: [{effect}]: {', '.join(missing)} is missing")
    try:
        return kind(**{key: _named(key, types[key], value) for key, value in table.items()})
    except ProfileError as error:
        raise ProfileError(f"{where}: [{effect}]: {error}") from error


def _named(key: str, kind: type, value: Any) -> Any:
    try:
        return _value(kind, value)
    except (ProfileError, OverflowError) as error:
        raise ProfileError(f"{key}: {error}") from error


def _value(kind: type, value: Any) -> Any:
    if kind is Curve:
        if not isinstance(value, list) or not all(_is_list(pair, 2) for pair in value):
            raise ProfileError(f"expected a curve [[speed, factor], …], got {value!r}")
        return Curve(tuple((_number(at), _number(factor)) for at, factor in value))
    if kind is RobotDistribution:
        return _distribution(value)
    return _number(value)


def _distribution(value: Any) -> RobotDistribution:
    if not isinstance(value, Mapping):
        return constant(_number(value))
    _refuse_unknown(value, (*_NAMED, "limit"), "a distribution")
    chosen = [kind for kind in _NAMED if kind in value]
    if len(chosen) != 1 or ("limit" in value and chosen != [DistributionKind.NORMAL]):
        raise ProfileError(
            "expected a number, { uniform = [low, high] }, { normal = [mean, sigma] } (which may"
            f" have a limit) or {{ robots = [one value a robot] }}, got {dict(value)!r}"
        )
    numbers = value[chosen[0]]
    if not _is_list(numbers):
        raise ProfileError(f"{chosen[0]}: expected a list of numbers, got {numbers!r}")
    limit = {"limit": _number(value["limit"])} if "limit" in value else {}
    return RobotDistribution(chosen[0], tuple(map(_number, numbers)), **limit)


def _number(value: Any) -> float:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not is_number or not abs(value) <= LARGEST:  # NaN is not either
        raise ProfileError(f"expected a number within ±{LARGEST:g}, got {value!r:.40}")
    return float(value)


def _is_list(value: Any, length: int | None = None) -> bool:
    return (
        isinstance(value, list)
        and (length is None or len(value) == length)
        and all(isinstance(n, (int, float)) and not isinstance(n, bool) for n in value)
    )


def _refuse_unknown(table: Mapping[str, Any], known: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in known:
            raise ProfileError(f"{where}: unknown key {key!r}; known are {', '.join(known)}")


def _plain(value: Any) -> Any:
    if isinstance(value, Curve):
        return [list(pair) for pair in value.points]
    if isinstance(value, RobotDistribution):
        if value.kind is DistributionKind.CONSTANT:
            return value.values[0]
        limit = {"limit": value.limit} if np.isfinite(value.limit) else {}
        return {value.kind.value: list(value.values), **limit}
    return value


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(_toml(entry) for entry in value) + "]"
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
        return f'"{escaped}"'
    return repr(float(value))
