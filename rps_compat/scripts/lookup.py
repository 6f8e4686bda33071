"""Where a name is looked up, and what an attribute of a value is.

A name is the scope's own, or that of a scope around it, or the module's; then it may come from a
``from … import *``, and last it is one of Python's own.
"""

from __future__ import annotations

import builtins

from rps_compat.scripts.changes import CHANGES
from rps_compat.scripts.exports import canonical, exports
from rps_compat.scripts.program import Module, Program
from rps_compat.scripts.values import (
    ANYTHING,
    FARTHEST,
    NONE,
    UNBOUND,
    UNKNOWN,
    Class,
    Function,
    Held,
    Instance,
    Method,
    Origin,
    OwnModule,
    Scope,
    Super,
    Value,
    Values,
)

_BUILTINS = frozenset(dir(builtins)) | {
    path.removeprefix("builtins.") for path in CHANGES if path.startswith("builtins.")
}
#: What scripts call so where a star that cannot be read may have brought it.
_CONVENTIONAL = {"np": "numpy", "plt": "matplotlib.pyplot"}


def look_up(program: Program, module: Module, scope: Scope, name: str) -> tuple[Values, str]:
    """Return what a name stands for, and the module whose star brought it, if one did.

    The second is "" where no star did.

    Parameters
    ----------
    program : Program
        The script and the modules beside it.
    module : Module
        Where it is asked for.
    scope : Scope
        Where in the module.
    name : str
        Name without dots.
    """
    found = _bound(scope, name)
    if found is not None and UNBOUND not in found:
        return found, ""
    brought, star = _from_star(program, module, name)
    rest = (found or NONE) - {UNBOUND}
    if brought is None and not rest:
        known = name in _BUILTINS
        return (frozenset({Origin(f"builtins.{name}")}) if known else ANYTHING), ""
    return rest | (brought or NONE), star


def _bound(scope: Scope, name: str) -> Values | None:
    """Return what the scopes bind `name` to, with UNBOUND in it if not always; None if nowhere."""
    if name in scope.elsewhere:
        return scope.elsewhere[name].ever.get(name)
    here = scope.ever.get(name) if name in scope.shared else scope.names.get(name)
    if here is not None and UNBOUND not in here:
        return here
    maybe = here or NONE
    if scope.local is not None and name in scope.local:  # bound later, as in a loop
        return (maybe - {UNBOUND}) or scope.ever.get(name, NONE)
    around = scope.parent
    if around is None:
        return here
    if scope.live:
        further = _bound(around, name)
        return here if further is None else maybe | further
    while around is not None:
        if name in around.ever or (around.local is not None and name in around.local):
            return maybe | around.ever.get(name, NONE)
        around = around.parent
    return here


def _from_star(program: Program, module: Module, name: str) -> tuple[Values | None, str]:
    """Return what a star of a module brings under `name`, None if none does, and which star."""
    unread = False
    for path in reversed(module.stars):
        own = program.module(path)
        if own is not None and own is not module:
            found = module_attribute(program, own, name, starred=True)
            if found is not None:
                return found, ""
            continue
        brings = exports(path, name)
        if brings:
            return frozenset({Origin(canonical(f"{path}.{name}"))}), path
        unread |= brings is None
    if unread and name not in _BUILTINS:
        usual = _CONVENTIONAL.get(name)
        return (frozenset({Origin(usual)}) if usual else ANYTHING), ""
    return None, ""


def module_attribute(
    program: Program, module: Module, name: str, starred: bool = False
) -> Values | None:
    """Return what a name is in a module that lies beside the script; None if it is not there.

    Parameters
    ----------
    program : Program
        The script and the modules beside it.
    module : Module
        One of the user's own.
    name : str
        Name without dots.
    starred : bool
        Whether a star asks, which brings no name with an underscore.
    """
    if starred and name.startswith("_"):
        return None
    found = module.scope.ever.get(name)
    if found is not None:
        return found
    inner = f"{module.name}.{name}"
    if program.module(inner) is not None:
        return frozenset({OwnModule(inner)})
    return _from_star(program, module, name)[0]


def attribute(program: Program, values: Values, name: str) -> Values:
    """Return what an attribute of something is.

    Parameters
    ----------
    program : Program
        The script and the modules beside it.
    values : frozenset
        What it is asked of.
    name : str
        What stands behind the dot.
    """
    out: Values = frozenset()
    for value in values:
        out |= _attribute_of(program, value, name)
    return out


def _attribute_of(program: Program, value: Value, name: str) -> Values:
    if isinstance(value, Origin):
        path = canonical(f"{value.path}.{name}")
        return frozenset({Origin(path)}) if path.count(".") < FARTHEST else ANYTHING
    if isinstance(value, OwnModule):
        module = program.module(value.name)
        return (module and module_attribute(program, module, name)) or program.absent
    if isinstance(value, (Instance, Class)):
        of = value.of if isinstance(value, Instance) else value
        return member(of, name, value) or program.absent
    if isinstance(value, Super):
        return _inherited(value.of, name, Instance(value.of)) or program.absent
    if isinstance(value, Held):
        return ANYTHING
    return program.robots_called(name) or program.absent


def member(of: Class, name: str, owner: Instance | Class) -> Values:
    """Return what a name is on an object or class; empty if the source does not tell.

    Parameters
    ----------
    of : Class
        Where it is looked up.
    name : str
        What stands behind the dot.
    owner : Instance or Class
        What it is asked of.
    """
    own = of.attributes.get(name)
    if own is None:
        return _inherited(of, name, owner)
    out: Values = frozenset()
    for value in own:
        out |= _asked_of(value, owner) if isinstance(value, Function) else {value}
    return out


def _inherited(of: Class, name: str, owner: Instance | Class, depth: int = 0) -> Values:
    """Return what the bases of a class have under `name`."""
    out: Values = frozenset()
    for base in of.bases:
        if isinstance(base, Origin):
            called = "()" if isinstance(owner, Instance) else ""
            out |= {Origin(canonical(f"{base.path}{called}.{name}"))}
        elif isinstance(base, Class) and depth < FARTHEST:
            if name in base.attributes:
                out |= member(base, name, owner)
            else:
                out |= _inherited(base, name, owner, depth + 1)
        elif base is UNKNOWN:
            out |= ANYTHING
    return out


def _asked_of(function: Function, owner: Instance | Class) -> Values:
    """Return what a function of a class is when it is asked of an object: a method, mostly."""
    how = function.decorators
    if "property" in how or "cached_property" in how:
        return function.returns or ANYTHING
    if "staticmethod" in how:
        return frozenset({function})
    if "classmethod" in how and isinstance(owner, Instance):
        return frozenset({Method(function, owner.of)})
    if isinstance(owner, Class) and "classmethod" not in how:
        return frozenset({function})
    return frozenset({Method(function, owner)})
