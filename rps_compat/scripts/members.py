"""What is the matter with a member, whatever it is asked of: a robot, a module, a class, a library.

A member of the API matters where not every generation has it, one of another library where not
every version has it.
"""

from __future__ import annotations

from rps_compat.scripts import api
from rps_compat.scripts.api import ApiName
from rps_compat.scripts.changes import Change, change_of
from rps_compat.scripts.exports import canonical
from rps_compat.scripts.libraries import is_available
from rps_compat.scripts.lookup import member
from rps_compat.scripts.program import ROBOTS
from rps_compat.scripts.values import Class, Instance, Origin, bases_of


def matter_of(path: str, name: str) -> ApiName | Change | None:
    """Return what is the matter with a member of an imported module, class or instance.

    Parameters
    ----------
    path : str
        Of the module, class or instance, as `Origin` has it; an instance ends with "()".
    name : str
        What is asked of it, without dots.
    """
    if path.removesuffix("()") in ROBOTS:
        return api.attribute_of_api(name)
    if path == "rps" or path.startswith("rps."):
        if "(" in path or not api.module_of_api(path).generations:
            return None
        entry = api.member_of_api(path, name)
        return None if entry.generations >= api.BOTH else entry
    return change_of(canonical(f"{path}.{name}"))


def matter_with(owner: object, name: str) -> ApiName | Change | None:
    """Return what is the matter with a member of a value; a script's own robots inherit theirs.

    Parameters
    ----------
    owner : object
        What the member is asked of, one of `rps_compat.scripts.values`.
    name : str
        What is asked of it, without dots.
    """
    if isinstance(owner, Origin):
        return matter_of(owner.path, name)
    if isinstance(owner, (Instance, Class)):
        of = owner.of if isinstance(owner, Instance) else owner
        found = member(of, name, owner)
        inherited = {v.path.removesuffix(f".{name}") for v in found if isinstance(v, Origin)}
        if bases_of(of) & ROBOTS and {p.removesuffix("()") for p in inherited} & ROBOTS:
            return api.attribute_of_api(name)
    return None


def is_elsewhere(owner: object) -> bool:
    """Return whether a value comes from a library that the testbed has not: it is another there.

    Parameters
    ----------
    owner : object
        One of `rps_compat.scripts.values`.
    """
    return isinstance(owner, Origin) and not (
        is_available(owner.path.partition(".")[0].removesuffix("()"))
        or owner.path.startswith("builtins.")
    )
