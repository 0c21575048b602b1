"""What a campaign finds: an invariant that does not hold."""

from __future__ import annotations

import msgspec


class Violation(msgspec.Struct, frozen=True, kw_only=True):
    """An invariant that does not hold in a run.

    Attributes
    ----------
    invariant : str
        Name of the invariant, in kebab case.
    says : str
        What broke, where and when, in one plain line.
    robot : int or None
        The robot that it is about; None: no single one.
    time_s : float or None
        When, in seconds from the start of the run; None: at no certain time.

    Examples
    --------
    >>> Violation(invariant="no-collision", says="robot 1 touches a wall at 3.2 s", robot=1).robot
    1
    """

    invariant: str
    says: str
    robot: int | None = None
    time_s: float | None = None
