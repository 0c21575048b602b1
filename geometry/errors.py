"""The errors that multisrt raises, under one root."""


class MultiSrtError(Exception):
    """Root of every error that multisrt raises on purpose."""


class InvalidInputError(MultiSrtError, ValueError):
    """What the caller gave cannot be used; the message says the value, the place and the remedy."""


class MapFormatError(InvalidInputError):
    """A map file cannot be read; the message names the file, the place in it and the remedy."""


class ClearanceError(InvalidInputError):
    """A body or a viewpoint is too close to an obstacle.

    Attributes
    ----------
    clearance_m : float
        Distance to the nearest obstacle in metres; negative or zero inside one.
    """

    def __init__(self, message: str, clearance_m: float) -> None:
        # Both are arguments of the exception, so that it can be copied.
        super().__init__(message, clearance_m)
        self.clearance_m = clearance_m

    def __str__(self) -> str:
        return str(self.args[0])
