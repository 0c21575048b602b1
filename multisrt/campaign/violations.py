"""What broke in a run."""

from __future__ import annotations

import msgspec


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
