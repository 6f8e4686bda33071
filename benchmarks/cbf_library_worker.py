"""One other library in a process of its own: certifies what `cbf_libraries.py` sends it.

Started with the Python of an environment that has the library, as ``cbf_library_worker.py NAME
STATES``: a candidate of `CANDIDATES`, and an ``.npz`` of states. Its first line tells versions;
then each line that it is sent is a round over all runs of a kind, answered by a line of JSON: the
answers and the CPU milliseconds of each. What is compiled was compiled before, by a round that
nobody counts. A call takes numpy arrays and gives numpy arrays, as a controller on a robot has
them; who can begin where the last step ended may do so within a run.

Each library is used by its public names and as its documentation recommends: the 36 pairs of nine
single integrators as its barriers, γ h³ as its class-K function, its own limit of speeds. A builder
returns what begins a run, and that what certifies a step of it.
"""

from __future__ import annotations

import json
import os
import sys
import time
from importlib.metadata import version

for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_variable] = "1"
os.environ["JAX_PLATFORMS"] = "cpu"
os.environ["JAX_ENABLE_X64"] = "1"
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"

import numpy as np  # noqa: E402


def pair_barriers(x, radius):
    """Return h of all pairs of a state robot by robot, in JAX."""
    import jax.numpy as jnp

    first, second = np.triu_indices(x.shape[0] // 2, 1)
    points = x.reshape(-1, 2)
    apart = points[first] - points[second]
    return jnp.sum(apart * apart, axis=1) - radius**2


def cbfpy(setup, relax_qp=True, backend="qpax", solver_tol=1e-3):
    """CBFpy: a config class with dynamics, barriers, and α; the defaults relax and stop at 1e-3."""
    import jax.numpy as jnp
    from cbfpy import CBF, CBFConfig

    size, radius, gain, speed = setup["size"], setup["radius"], setup["gain"], setup["speed"]

    class Team(CBFConfig):
        def __init__(self):
            limits = speed * np.ones(size)
            options = {"relax_qp": relax_qp, "backend": backend, "solver_tol": solver_tol}
            super().__init__(n=size, m=size, u_min=-limits, u_max=limits, **options)

        def f(self, z):
            return jnp.zeros(size)

        def g(self, z):
            return jnp.eye(size)

        def h_1(self, z):
            return pair_barriers(z, radius)

        def alpha(self, h):
            return gain * h**3

    cbf = CBF.from_config(Team())
    return lambda: lambda desired, x: np.asarray(cbf.safety_filter(x, desired))


def cbfkit(setup, solver="jaxopt", **options):
    """CBFKit: a certificate for each pair, its cubic class-K condition, and the vanilla law."""
    import jax
    import jax.numpy as jnp
    from cbfkit.certificates import concatenate_certificates, generate_certificate
    from cbfkit.certificates.conditions.barrier_conditions.zeroing_barriers import cubic_class_k
    from cbfkit.controllers.cbf_clf import vanilla_cbf_clf_qp_controller
    from cbfkit.optimization.quadratic_program import get_solver
    from cbfkit.utils.user_types import ControllerData

    size, radius = setup["size"], setup["radius"]

    def apart(i, j):
        def h(x):
            return (x[2 * i] - x[2 * j]) ** 2 + (x[2 * i + 1] - x[2 * j + 1]) ** 2 - radius**2

        return h

    barriers = concatenate_certificates(
        *(
            generate_certificate(apart(i, j), cubic_class_k(setup["gain"]))
            for i, j in zip(*np.triu_indices(size // 2, 1), strict=True)
        )
    )
    law = vanilla_cbf_clf_qp_controller(
        control_limits=jnp.full(size, setup["speed"]),
        dynamics_func=lambda _: (jnp.zeros(size), jnp.eye(size)),
        barriers=barriers,
        solver=get_solver(solver, **options),
    )
    key, law = jax.random.PRNGKey(0), jax.jit(law)

    def start():
        data = ControllerData()

        def certify(desired, x):
            nonlocal data  # solvers begin where they ended, as in its simulator
            answer, data = law(0.0, x, desired, key, data)
            return np.asarray(answer)

        return certify

    return start


def cbfjax(setup, qp_solver="qpax"):
    """CBFJAX: one barrier of many dimensions; a filter that is given the law of what is wished."""
    import cbfjax as library
    from cbfjax.dynamics.single_integrator import SingleIntegratorDynamics

    library.configure_jax(platform="cpu", enable_x64=True)
    size, radius, gain, speed = setup["size"], setup["radius"], setup["gain"], setup["speed"]
    dynamics = SingleIntegratorDynamics(dim=size)
    pairs = library.Barrier(
        barrier_func=lambda x: pair_barriers(x, radius), dynamics=dynamics, rel_deg=1
    )
    filtered = library.MinIntervInputConstQPSafeControl(
        action_dim=size,
        alpha=lambda h: gain * h**3,
        params={"slacked": False, "qp_solver": qp_solver},
        dynamics=dynamics,
        barrier=library.MultiBarriers(barriers=[pairs], dynamics=dynamics, multidim=True),
        # A stateful law of what is wished: its state is the wish of the step.
        desired_control=lambda x, wish: (wish, wish),
        desired_control_init_state=lambda: np.zeros(size),
        control_low=[-speed] * size,
        control_high=[speed] * size,
    )

    def start():
        state = filtered.get_init_state()

        def certify(desired, x):
            nonlocal state  # of the wish, and where the solver ended if it begins there again
            given = (desired, state[1]) if isinstance(state, tuple) else desired
            answer, state = filtered.optimal_control(x, given)
            return np.asarray(answer)

        return certify

    return start


def rps(setup, accurate=False):
    """Robotarium's utilities; at import they set cvxopt to 1e-2 for the whole process."""
    from cvxopt import solvers

    from rps.utilities.barrier_certificates import create_si_barrier_certificate

    if accurate:
        solvers.options.update(reltol=1e-9, feastol=1e-9, abstol=1e-9)
    certify = create_si_barrier_certificate(setup["radius"], setup["gain"], setup["speed"])
    return lambda: lambda wish, x: certify(wish.reshape(-1, 2).T, x.reshape(-1, 2).T).T.ravel()


#: What a name on the command line builds, and which distributions it names.
CANDIDATES = {
    "cbfpy": (cbfpy, {}, ("cbfpy", "qpax")),
    "cbfpy-hard": (cbfpy, {"relax_qp": False, "solver_tol": 1e-8}, ("cbfpy", "qpax")),
    "cbfpy-elastiqp": (
        cbfpy,
        {"backend": "elastiqp", "solver_tol": 1e-8},
        ("cbfpy", "elastiqp"),
    ),
    "cbfkit": (cbfkit, {}, ("cbfkit", "jaxopt")),
    "cbfkit-tight": (cbfkit, {"tol": 1e-5, "max_iter": 5000}, ("cbfkit", "jaxopt")),
    "cbfkit-fast": (cbfkit, {"solver": "fast"}, ("cbfkit",)),
    "cbfjax": (cbfjax, {}, ("cbfjax", "qpax")),
    "cbfjax-osqp": (cbfjax, {"qp_solver": "jaxopt_osqp"}, ("cbfjax", "jaxopt")),
    "rps": (rps, {}, ("robotarium-python-simulator", "cvxopt")),
    "rps-tight": (rps, {"accurate": True}, ("robotarium-python-simulator", "cvxopt")),
}


def main():
    """Certify round after round, until the input ends."""
    build, options, names = CANDIDATES[sys.argv[1]]
    told, sys.stdout = sys.stdout, sys.stderr  # libraries print, too
    states = np.load(sys.argv[2])
    setup = {name: float(states[name]) for name in ("radius", "gain", "speed")}
    start = build({**setup, "size": int(states["size"])}, **options)
    print(", ".join(f"{name} {version(name)}" for name in names), file=told, flush=True)
    for line in sys.stdin:
        answers, cost = [], []
        wishes, at = states[f"{line.strip()} wishes"], states[f"{line.strip()} at"]
        for run_wishes, run_at in zip(wishes, at, strict=True):
            certify = start()
            for desired, x in zip(run_wishes, run_at, strict=True):
                before = time.process_time()
                answer = certify(desired, x)
                cost.append(1e3 * (time.process_time() - before))
                answers.append(answer.tolist())
        print(json.dumps({"answers": answers, "ms": cost}), file=told, flush=True)


if __name__ == "__main__":
    main()
