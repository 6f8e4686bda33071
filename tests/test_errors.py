"""Whatever this distribution raises for a caller to mend has one root."""

import importlib
import inspect
import pkgutil

import pytest

from barrier_certificates.certificate_errors import CertificateError, PosflockError
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from posflock_robotarium.flocking import errors
from rps_compat.errors import RobotariumError
from rps_compat.v1.utilities.barrier_certificates import (
    create_single_integrator_barrier_certificate,
)

PACKAGES = ("barrier_certificates", "rps_compat", "posflock_robotarium")


def modules():
    for name in PACKAGES:
        package = importlib.import_module(name)
        for found in pkgutil.walk_packages(package.__path__, f"{name}."):
            if not found.name.endswith("__main__"):
                yield importlib.import_module(found.name)


def test_every_error_has_the_one_root():
    found = {
        kind
        for module in modules()
        for kind in vars(module).values()
        if inspect.isclass(kind)
        and issubclass(kind, Exception)
        and kind.__module__.startswith(PACKAGES)
    }
    assert len(found) > 30
    assert {kind for kind in found if not issubclass(kind, PosflockError)} == set()
    assert errors.PosflockError is PosflockError


@pytest.mark.parametrize(
    ("mistake", "also"),
    [
        (lambda: SingleIntegratorCertificate(safety_radius=-1.0), (CertificateError, ValueError)),
        (
            lambda: create_single_integrator_barrier_certificate(barrier_gain=0),
            (RobotariumError, AssertionError, TypeError, ValueError),
        ),
    ],
)
def test_one_except_catches_mistakes_of_every_package(mistake, also):
    with pytest.raises(PosflockError, match="expected") as caught:
        mistake()
    assert isinstance(caught.value, also[0])
    for kind in also[1:]:  # what callers of the usual kind catch
        assert isinstance(caught.value, kind)
