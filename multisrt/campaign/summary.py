"""A campaign in a table: what its missions came to, by strategy."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from statistics import median

import msgspec

from multisrt.campaign.store import Row
from multisrt.geometry.errors import counted


class StrategySummary(msgspec.Struct, frozen=True, kw_only=True):
    """What the missions of one strategy came to.

    Attributes
    ----------
    strategy : str
        Its name; "all" for all of them.
    missions : int
        Number of missions.
    refused : int
        Number of draws that the program refused as impossible.
    repeated : int
        Number of missions that were repeated in another process.
    outcomes : dict of str to int
        Number of missions by how they ended.
    violations : dict of str to int
        Number of missions by the invariant that they violate.
    failed : int
        Number of missions that violate any.
    median_s : float
        Median elapsed time of a run and the judging of it (s).
    """

    strategy: str
    missions: int
    refused: int
    repeated: int
    outcomes: dict[str, int]
    violations: dict[str, int]
    failed: int
    median_s: float


def summary(rows: Iterable[Row]) -> list[StrategySummary]:
    """Return what missions came to: of each strategy, then of all.

    Parameters
    ----------
    rows : iterable of Row
        The missions.

    Returns
    -------
    list of StrategySummary
        Strategies in the order of their names; empty if there is no mission.

    Examples
    --------
    >>> summary([])
    []
    """
    by_strategy: dict[str, list[Row]] = {}
    for row in rows:
        by_strategy.setdefault(row.strategy, []).append(row)
    if not by_strategy:
        return []
    every = [row for found in by_strategy.values() for row in found]
    return [
        *(_summary(name, found) for name, found in sorted(by_strategy.items())),
        _summary("all", every),
    ]


def further(repeated: int, refused: int) -> str:
    """Return how many missions were repeated, and draws made again, in words.

    Parameters
    ----------
    repeated, refused : int
        As in `StrategySummary`.

    Examples
    --------
    >>> further(1, 2)
    '1 was repeated in another process; 2 draws were impossible and drawn again'
    """
    return (
        f"{repeated:,} {_were(repeated)} repeated in another process; "
        f"{counted(refused, 'draw')} {_were(refused)} impossible and drawn again"
    )


def _were(number: int) -> str:
    return "was" if number == 1 else "were"


def _summary(strategy: str, rows: list[Row]) -> StrategySummary:
    violated = Counter(v.invariant for row in rows for v in row.violations)
    return StrategySummary(
        strategy=strategy,
        missions=len(rows),
        refused=sum(row.refused for row in rows),
        repeated=sum(row.repeated for row in rows),
        outcomes=dict(Counter(row.outcome for row in rows)),
        violations=dict(sorted(violated.items())),
        failed=sum(bool(row.violations) for row in rows),
        median_s=median(row.run_s + row.check_s for row in rows),
    )
