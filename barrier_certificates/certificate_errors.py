"""What can go wrong with a certificate, each under its own name and all under one."""


class CertificateError(Exception):
    """Anything this package raises: the message says what was got and what was expected."""


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
