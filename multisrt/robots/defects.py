"""A defect of an explorer."""

from __future__ import annotations

import sysconfig
import traceback
from pathlib import Path
from typing import NamedTuple

from multisrt.geometry.errors import InvalidInputError

_LIBRARIES = (
    str(Path(__file__).parents[1]),
    *(sysconfig.get_path(name) for name in ("stdlib", "purelib", "platlib")),
)
"""Folders of code that is not the user's."""


class Flaw(NamedTuple):
    """What an explorer did, and what to change."""

    what: str
    remedy: str


class ExplorerDefect(InvalidInputError, AssertionError):
    """An explorer does what the contract of explorers does not allow.

    The simulation raises it where it cannot do what an explorer yields, and
    `multisrt.testing.check_explorer` for all else that the contract asks for.

    Attributes
    ----------
    what : str
        What it did.
    where : str
        Which robot; for `check_explorer` also in which run, and at which action.
    remedy : str
        What to change.

    Examples
    --------
    >>> from multisrt.testing import check_explorer, two_rooms
    >>> class Idle:
    ...     def __init__(self, me):
    ...         self.me = me
    ...
    ...     def run(self):
    ...         yield from ()
    >>> try:
    ...     check_explorer(Idle, worlds=[two_rooms()])
    ... except ExplorerDefect as defect:
    ...     print(defect.what)
    its run() ended without a last action Done
    """

    def __init__(self, what: str, where: str, remedy: str) -> None:
        super().__init__(what, where, remedy)
        self.what = what
        self.where = where
        self.remedy = remedy

    def __str__(self) -> str:
        return f"{self.where}: {self.what}; {self.remedy}"


def place_of(error: BaseException) -> str:
    """Return where an exception was raised, in the user's own code if that took part.

    Parameters
    ----------
    error : BaseException
        The exception, with its traceback.

    Returns
    -------
    str
        Such as ``mine.py:8, in run``; empty without a traceback.

    Examples
    --------
    >>> place_of(ValueError("never raised"))
    ''
    """
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if not frame.filename.startswith(_LIBRARIES)]
    for frame in reversed(own or frames):
        return f"{Path(frame.filename).name}:{frame.lineno}, in {frame.name}"
    return ""


def brief(value: object, length: int = 80) -> str:
    """Return the representation of a value, cut to a length."""
    text = repr(value)
    return text if len(text) <= length else f"{text[: length - 3]}..."


def article(noun: str) -> str:
    """Return a noun, such as the name of a type, with its indefinite article."""
    return f"{'an' if noun[:1].lower() in 'aeiou' else 'a'} {noun}"
