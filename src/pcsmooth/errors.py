"""The exceptions of pcsmooth. This module imports nothing that takes time."""

from typing import Any

from pcsmooth.printable import printable


class PcsmoothError(Exception):
    """Base of every error that pcsmooth raises on purpose."""


class InvalidInputError(PcsmoothError, ValueError):
    """An argument or a cloud that cannot be processed: wrong shape, value or option."""


class NoFinitePointError(InvalidInputError):
    """A cloud of which no point can take part."""

    def __init__(self) -> None:
        super().__init__("there is no point with finite coordinates; nothing to do")


class CloudFileError(PcsmoothError):
    """A file that cannot be read or written as a cloud, or read as what else it is to be.

    Parameters
    ----------
    path : str
        The file, as the user named it.
    cause : str
        What is wrong, with line or row where known.
    remedy : str
        What the user can do about it.
    """

    def __init__(self, path: str, cause: str, remedy: str) -> None:
        super().__init__(f"{printable(path)}: {cause}; {remedy}")
        self.path = path
        self.cause = cause
        self.remedy = remedy

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle: processes send what went wrong to each other."""
        return type(self), (self.path, self.cause, self.remedy), self.__dict__
