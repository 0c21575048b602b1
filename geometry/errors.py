"""The errors that multisrt raises, under one root."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


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


def did_you_mean(word: object, known: Iterable[object]) -> str:
    """Give the hint at the nearest of the known words, for behind an unknown one; or nothing."""
    close = difflib.get_close_matches(str(word), list(map(str, known)), n=1)
    return f" (did you mean {close[0]!r}?)" if close else ""
