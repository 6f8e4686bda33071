"""Compute a study on a Dask cluster.

A cluster runs whatever its clients send it, and a client believes whatever its workers answer:
both are programs of each other's. Over ``tcp://`` anybody who reaches the scheduler's port is such
a client. ``tls://`` admits those alone who hold a certificate, and encrypts what is sent.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from posflock_robotarium import __version__
from posflock_robotarium.flocking.errors import PosflockError
from posflock_robotarium.sweep.execution import DIED, Executor, Job, words_of
from posflock_robotarium.sweep.store import Row
from posflock_robotarium.sweep.study import PlannedRun

if TYPE_CHECKING:
    from distributed import Client


#: Seconds after which a cluster that has lost all workers is given up: they may be replaced.
WITHOUT_WORKERS = 300.0
#: Seconds between two looks at who works there.
_LOOK = 2.0


class ClusterError(PosflockError):
    """A Dask cluster cannot be used."""


@dataclass(frozen=True)
class Certificates:
    """By what a client and a cluster know each other, as PEM files.

    Attributes
    ----------
    ca : Path
        Certificate of the authority that signed those of the cluster.
    cert : Path
        This client's certificate, signed by the same authority.
    key : Path
        Its private key.

    Raises
    ------
    ClusterError
        Where one of them is no file.
    """

    ca: Path
    cert: Path
    key: Path

    def __post_init__(self) -> None:
        for name in ("ca", "cert", "key"):
            if not getattr(self, name).is_file():
                raise ClusterError(f"--tls-{name}: there is no file {getattr(self, name)}")

    @classmethod
    def of(cls, ca: Path | None, cert: Path | None, key: Path | None) -> Certificates | None:
        """Return all three, or None where none is given.

        Parameters
        ----------
        ca, cert, key : Path or None
            The files that were named.

        Raises
        ------
        ClusterError
            Where one or two are given.
        """
        if ca is None and cert is None and key is None:
            return None
        if ca is None or cert is None or key is None:
            raise ClusterError(
                "expected all of --tls-ca, --tls-cert and --tls-key, or none of them, for what"
                " Dask's own configuration says"
            )
        return cls(ca, cert, key)


@contextmanager
def on_cluster(
    address: str, patience: float = 10.0, certificates: Certificates | None = None
) -> Iterator[Executor]:
    """Connect to a Dask scheduler and give an executor that sends it the work.

    Dask's workers pin BLAS to one thread by themselves, and its scheduler gives the runs of
    a worker that died to another; a run that kills one worker after another has failed.

    Parameters
    ----------
    address : str
        Of the scheduler, such as ``tls://10.0.0.1:8786``.
    patience : float
        Seconds to wait for the scheduler.
    certificates : Certificates, optional
        For ``tls://``; by default what Dask's own configuration says.

    Raises
    ------
    ClusterError
        Where Dask is not installed, nobody answers, a worker has another version, the scheduler
        goes away, or it has had no worker for :data:`WITHOUT_WORKERS`; what was finished is in
        the store by then.
    """
    client = _connected(address, patience, certificates)
    try:
        try:
            _require_same_version(client.run(_version))
        except (OSError, TimeoutError) as error:
            raise _lost(address) from error
        yield lambda job, work: _results(client, address, job, work)
    finally:
        with contextlib.suppress(OSError, TimeoutError):
            client.close()


def _connected(address: str, patience: float, certificates: Certificates | None) -> Client:
    try:
        from distributed import Client, Security
    except ImportError as error:
        raise ClusterError(
            "a cluster needs Dask: pip install 'posflock-robotarium[cluster]'"
        ) from error
    if certificates is not None and not address.startswith("tls://"):
        raise ClusterError(f"certificates are for an address tls://…, got {address}")
    try:
        security = None
        if certificates is not None:
            security = Security(
                tls_ca_file=str(certificates.ca),
                tls_client_cert=str(certificates.cert),
                tls_client_key=str(certificates.key),
                require_encryption=True,
            )
        return Client(address, timeout=patience, set_as_default=False, security=security)
    except (OSError, ValueError, TypeError, RuntimeError, TimeoutError) as error:
        hint = ""
        if address.startswith("tls://") and certificates is None:
            hint = "; tls:// needs --tls-ca, --tls-cert and --tls-key, or Dask's own configuration"
        raise ClusterError(
            f"no Dask scheduler answers at {address}: {words_of(error)}{hint}"
        ) from error


def _results(
    client: Client, address: str, job: Job, work: Sequence[Sequence[PlannedRun]]
) -> Iterator[list[Row]]:
    """Yield the rows of batches as they are finished.

    Dask blames all runs that a worker had before it when it died, so those that are blamed are
    computed once more, each when no other is under way.
    """
    suspects: list[PlannedRun] = []
    for batch, rows in _finished(client, address, job, work):
        if rows is None:
            suspects += batch
        else:
            yield rows
    for run in suspects:
        for batch, rows in _finished(client, address, job, [[run]]):
            yield job.failed(batch, DIED) if rows is None else rows


def _finished(
    client: Client, address: str, job: Job, work: Sequence[Sequence[PlannedRun]]
) -> Iterator[tuple[Sequence[PlannedRun], list[Row] | None]]:
    """Yield batches and their rows; None where the workers that had a batch died."""
    from distributed import CancelledError, KilledWorker, as_completed

    futures = client.map(job, work, pure=False, batch_size=100)
    batch_of: dict[Any, Sequence[PlannedRun]] = dict(zip(futures, work, strict=True))
    completed = as_completed(futures, loop=client.loop)
    while not completed.is_empty():
        _await_one(completed, client, address)
        future = next(completed)
        rows: list[Row] | None = None
        try:
            rows = future.result()
        except KilledWorker:
            pass
        except (CancelledError, OSError, TimeoutError) as error:
            raise _lost(address) from error
        yield batch_of.pop(future), rows
        future.release()


def _await_one(completed: Any, client: Client, address: str) -> None:
    """Wait until a batch is finished, as long as somebody is there to compute it."""
    pause, looked, seen = 0.002, time.monotonic(), time.monotonic()
    while not completed.has_ready():
        time.sleep(pause)
        pause = min(2.0 * pause, 0.1)
        if time.monotonic() - looked < _LOOK:
            continue
        try:
            if client.nthreads() or client.status != "running":  # who has gone says so himself
                seen = time.monotonic()
        except (OSError, TimeoutError) as error:
            raise _lost(address) from error
        looked = time.monotonic()
        if looked - seen > WITHOUT_WORKERS:
            raise ClusterError(
                f"the Dask scheduler at {address} has had no worker for {WITHOUT_WORKERS:g} s;"
                " finished runs are in the store: start workers, then start again"
            )


def _lost(address: str) -> ClusterError:
    return ClusterError(
        f"the Dask scheduler at {address} has gone; finished runs are in the store: start again"
    )


def _version() -> str:
    return __version__


def _require_same_version(versions: dict[str, str]) -> None:
    others = {worker: found for worker, found in versions.items() if found != __version__}
    if others:
        worker, found = next(iter(others.items()))
        raise ClusterError(
            f"posflock-robotarium {__version__} is expected on every worker; {worker} has {found}"
        )
