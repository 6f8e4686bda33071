"""The errors a user can make, all under one name so that one ``except`` catches them."""


class PosflockError(Exception):
    """Something the caller can mend: the message says what was got and what was expected."""


class ParameterError(PosflockError, ValueError):
    """A parameter, array or option is outside what the model admits."""


class OutputError(PosflockError, OSError):
    """Results cannot be written where they were asked for."""


class LogError(PosflockError):
    """A pose log cannot be read, or does not hold what it claims."""
