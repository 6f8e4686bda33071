"""The errors a user can make, all under the one root of this distribution."""

from barrier_certificates.certificate_errors import OutputError, PosflockError

__all__ = ["LogError", "OutputError", "ParameterError", "PosflockError"]


class ParameterError(PosflockError, ValueError):
    """A parameter, array or option is outside what the model admits."""


class LogError(PosflockError):
    """A pose log cannot be read, or does not hold what it claims."""
