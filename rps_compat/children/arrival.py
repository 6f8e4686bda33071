"""A process that a script has started afresh joins the run when it imports ``rps``."""

import atexit
import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from rps_compat.children.family import Family
from rps_compat.children.plan import ChildError, plan_of_this_process
from rps_compat.clock import SimulatedClock
from rps_compat.old_numpy import old_numpy_names
from rps_compat.recording import Recording
from rps_compat.session import Session, use
from rps_compat.surroundings import headless_matplotlib

#: What stands around the script of this process, until it ends.
_surroundings = contextlib.ExitStack()


def join_run() -> None:
    """Join the run that this process belongs to, if it still goes on."""
    plan = plan_of_this_process()
    if plan is None:
        return
    clock = SimulatedClock()
    refuse = None
    try:
        realism, open_log = plan.functions()
    except ChildError as error:
        realism, open_log, refuse = None, None, _refusing(error)
    session = Session(
        initial=plan.initial,
        seed=plan.seed,
        realism=refuse or realism,
        wait=False if plan.headless else None,
    )
    about = {"script": plan.script, "api": plan.api, "seed": plan.seed}
    out = None if plan.out is None else Path(plan.out)
    Family(plan, session, Recording(out, refuse or open_log, about, clock.advance)).arrive()
    use(session)
    atexit.register(_surroundings.close)
    _surroundings.enter_context(old_numpy_names())
    if plan.headless:
        _surroundings.enter_context(clock.in_force())
        _surroundings.enter_context(headless_matplotlib())


def _refusing(error: ChildError) -> Callable[..., Any]:
    def refuse(*_: Any) -> NoReturn:
        raise error

    return refuse
