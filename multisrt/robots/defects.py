"""A defect of an explorer."""

from __future__ import annotations

import re
from typing import NamedTuple, NoReturn

from multisrt.geometry.errors import InvalidInputError, escaped

_ADDRESS = re.compile(r" (object )?at 0x[0-9a-fA-F]+")


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

    def in_run(self, strategy: str, time_s: float) -> ExplorerDefect:
        """Return the same defect with its strategy and its time (s), unless its place tells more.

        Examples
        --------
        >>> defect = ExplorerDefect("it yielded None", "the explorer of robot 0", "yield Sense()")
        >>> print(defect.in_run("mine", 12.5))
        the explorer of robot 0 ('mine') at 12.5 s: it yielded None; yield Sense()
        """
        if not self.is_refusal:
            return self
        return ExplorerDefect(
            self.what, f"{self.where} ({strategy!r}) at {time_s:g} s", self.remedy
        )

    @property
    def is_refusal(self) -> bool:
        """Whether it is told without a place in a run."""
        return re.fullmatch(r"(building )?the explorer of robot \d+", self.where) is not None


def refuse(robot: int, what: str, remedy: str) -> NoReturn:
    """Raise the error of an explorer that does what it may not.

    Parameters
    ----------
    robot : int
        Its robot.
    what : str
        What it did.
    remedy : str
        What to change.

    Raises
    ------
    ExplorerDefect
        Always.
    """
    raise ExplorerDefect(what, f"the explorer of robot {robot}", remedy) from None


def brief(value: object, length: int = 80) -> str:
    """Return the representation of a value on one line, cut to a length.

    Examples
    --------
    >>> brief(object()), brief(["a line" * 100], 20)
    ('<object>', "['a linea linea l...")
    """
    try:
        text = one_line(repr(value))
    except Exception:  # of the value's own code, or too deep
        text = f"<{type(value).__name__}>"
    return text if len(text) <= length else f"{text[: length - 3]}..."


def one_line(text: str) -> str:
    """Return a text on one line, without addresses in memory, which differ from run to run."""
    return escaped(" ".join(_ADDRESS.sub("", text).split()))


def article(noun: str) -> str:
    """Return a noun, such as the name of a type, with its indefinite article."""
    return f"{'an' if noun[:1].lower() in 'aeiou' else 'a'} {noun}"


def described(value: object) -> str:
    """Return a value with its type, as text for a message."""
    return f"{brief(value)}, {article(type(value).__name__)}"
