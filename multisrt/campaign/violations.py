"""What broke in a run."""

from __future__ import annotations

from typing import Final

import msgspec

MAX_LENGTH: Final = 160
"""Maximum length of what violations say, in characters: with the replay it is a line or two."""

MAX_QUOTED: Final = 37
"""Maximum length of the reason of a robot in it, in characters."""


def quoted(text: str, most: int = MAX_QUOTED) -> str:
    """Return a text of at most some characters; dots mark a cut.

    Examples
    --------
    >>> quoted("boxed in by robots 1, 2, 3, 4, 5 and 6", 20)
    'boxed in by robot...'
    """
    return text if len(text) <= most else f"{text[: most - 3]}..."


class Violation(msgspec.Struct, frozen=True, kw_only=True):
    """An invariant that a run broke.

    Attributes
    ----------
    invariant : str
        Its name in `multisrt.campaign.invariants.INVARIANTS`, such as ``no-collision``.
    says : str
        One plain line: what broke, where, when.
    robot : int or None
        The robot that broke it, if it is one.
    time_s : float or None
        When, in seconds from the start of the run, if it was at one moment.

    Examples
    --------
    >>> print(Violation(invariant="ends", says="no reason is given", time_s=12.0))
    ends: no reason is given
    """

    invariant: str
    says: str
    robot: int | None = None
    time_s: float | None = None

    def __str__(self) -> str:
        return f"{self.invariant}: {self.says}"
