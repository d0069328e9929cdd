"""Exceptions of the package. Their texts are those of the command `stickslip`."""


class StickslipError(Exception):
    """Any error of the package."""


class BadInput(StickslipError, ValueError):
    """Something given can't be used: an argument, a campaign, a file."""


class FmuFailed(StickslipError, RuntimeError):
    """The FMU gave up while it ran."""


class NotWritten(StickslipError, OSError):
    """A file or folder can't be written."""


class GateFailed(StickslipError):
    """A run's NRMSE is above the limit asked for."""


class Stopped(StickslipError):
    """The work was stopped before its end."""
