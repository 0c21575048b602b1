"""Violations of invariants by a run."""

from __future__ import annotations

from typing import Final

import msgspec

MAX_LENGTH: Final = 160
"""Maximum length of the text of a violation, in characters."""

MAX_QUOTED: Final = 37
"""Maximum length of the reason of a robot that is quoted in it, in characters."""


def quoted(text: str, max_length: int = MAX_QUOTED) -> str:
    """Return a text shortened to at most `max_length` characters, with dots at its end.

    Examples
    --------
    >>> quoted("boxed in by robots 1, 2, 3, 4, 5 and 6", 20)
    'boxed in by robot...'
    """
    return text if len(text) <= max_length else f"{text[: max_length - 3]}..."


class Violation(msgspec.Struct, frozen=True, kw_only=True):
    """The violation of an invariant by a run.

    Attributes
    ----------
    invariant : str
        Its name in `multisrt.campaign.invariants.INVARIANTS`, such as ``no-collision``.
    says : str
        One line: what went wrong, where and when.
    robot : int or None
        The robot concerned, if it is a single one.
    time_s : float or None
        Time in seconds from the start of the run, if it is a single moment.

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
