"""The one root of all errors that a caller can mend, and what can go wrong with a certificate.

That results cannot be written is said by all three packages, and so stands here, too.
"""

__all__ = [
    "CertificateError",
    "EngineNotInstalledError",
    "InfeasibleError",
    "NotFiniteError",
    "OutputError",
    "ParameterError",
    "PosflockError",
    "ShapeError",
    "SolverNotInstalledError",
]


class PosflockError(Exception):
    """Something the caller can mend: the message says what was got and what was expected.

    The root of all errors of this distribution: one ``except PosflockError`` catches them all.
    """


class OutputError(PosflockError, OSError):
    """Results cannot be written where they were asked for."""


class CertificateError(PosflockError):
    """Anything that the certificates raise."""


class ParameterError(CertificateError, ValueError):
    """A radius, gain, limit or option is outside what the mathematics admits."""


class ShapeError(CertificateError, ValueError):
    """An array does not have the shape the certificate needs."""


class InfeasibleError(CertificateError):
    """No velocity satisfies every row, and the policy was to raise."""


class NotFiniteError(CertificateError, ValueError):
    """A pose or a command holds NaN or infinity, and the policy was to raise."""


class SolverNotInstalledError(CertificateError, ImportError):
    """The solver asked for by name is not installed; the message says which extra brings it."""


class EngineNotInstalledError(CertificateError, ImportError):
    """Compiled code was asked for where nothing compiles; the message says which extra does."""
