"""The exceptions of planish, one for each kind of error."""


class Error(Exception):
    """Wrong input, no memory, or a file that cannot be written.

    The message says what, where, the value and the remedy.
    """

    element: int
    """Index of the face, vertex or byte that the message speaks of; -1 for none."""

    def __init__(self, message: str = "", element: int = -1) -> None:
        super().__init__(message)
        self.element = element


class InvalidArgument(Error, ValueError):
    """An argument is out of range or contradicts another."""


class UnreadableInput(Error):
    """A file is missing or malformed."""


class UnusableMesh(Error, ValueError):
    """No surface can be made of the mesh."""


class NoDevice(Error):
    """What the work needs is missing."""


class MissingProgram(NoDevice):
    """A program that the work needs is missing: planish-reconstruct, for points."""


class DeviceLost(Error):
    """The device stopped answering."""


class OutOfMemory(Error, MemoryError):
    """Memory does not suffice; raised before it is taken."""


class UnwritableOutput(Error):
    """A file could not be written; the old one is as it was."""


class Cancelled(Error):
    """The function that was given as `cancelled` returned true."""
