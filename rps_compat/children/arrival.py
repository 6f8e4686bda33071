"""A process that a script has started afresh joins the run when it imports ``rps``."""

import atexit
import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from rps_compat.bridges import bridge
from rps_compat.children.family import Family, has_family
from rps_compat.children.plan import ChildError, plan_of_this_process
from rps_compat.clock import SimulatedClock
from rps_compat.clock.stand_ins import in_force
from rps_compat.install import install
from rps_compat.recording import Recording
from rps_compat.repeatable import repeatable
from rps_compat.session import Session, use
from rps_compat.surroundings import headless_matplotlib

#: What stands around the script of this process, until it ends.
_surroundings = contextlib.ExitStack()


def join_run(as_worker: bool = False) -> None:
    """Join the run that this process belongs to, if it still goes on; a second call does nothing.

    Parameters
    ----------
    as_worker
        Whether `multiprocessing` is about to start work here, and has not run the script yet.
    """
    plan = plan_of_this_process()
    if plan is None or has_family():
        return
    if as_worker:
        install(plan.generation)
    clock = SimulatedClock()
    refuse = None
    try:
        profile, open_log = plan.guests()
    except ChildError as error:
        profile, open_log, refuse = None, None, _refusing(error)
    session = Session(
        initial=plan.initial,
        seed=plan.seed,
        realism=refuse or (None if profile is None else profile.start),
        pace=clock if plan.headless else None,
    )
    about = {
        "script": plan.script,
        "generation": plan.generation,
        "seed": plan.seed,
        "simulated": True,
        "profile": "ideal" if profile is None else profile.name,
    }
    out = None if plan.out is None else Path(plan.out)
    family = Family(plan, session, Recording(out, refuse or open_log, about))
    _surroundings.enter_context(repeatable(plan.seed))
    family.arrive(as_worker)
    use(session)
    atexit.register(_surroundings.close)
    bridge(_surroundings)
    if plan.headless:
        _surroundings.enter_context(in_force(clock))
        _surroundings.enter_context(headless_matplotlib())


def _refusing(error: ChildError) -> Callable[..., Any]:
    def refuse(*_: Any) -> NoReturn:
        raise error

    return refuse
