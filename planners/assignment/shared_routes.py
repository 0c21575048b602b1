"""Routes of a team over targets, the longest as short as possible."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError

UNREACHABLE = np.iinfo(np.int64).max // 4
"""Cost in whole units of a way that there is not."""

MAX_PASSES = 20
"""Bounds the number of targets that are moved to better places of routes."""

Tour = list[int]


@dataclass(frozen=True, slots=True, kw_only=True)
class SharedRoutes:
    """The routes of a team.

    Attributes
    ----------
    routes : tuple of tuple of int
        For each robot the targets in the order in which it goes there.
    left_out : tuple of int
        Targets that no robot can reach or may go to.
    longest : int
        Length of the longest route, its robot's head start included.
    """

    routes: tuple[tuple[int, ...], ...]
    left_out: tuple[int, ...]
    longest: int

    @property
    def cost(self) -> tuple[int, int]:
        """What is to be small: the number of targets left out, then the longest route."""
        return len(self.left_out), self.longest


def shared_routes(
    starts: ArrayLike,
    between: ArrayLike,
    *,
    allowed: ArrayLike | None = None,
    before: ArrayLike | None = None,
) -> SharedRoutes:
    """Share targets among robots whose routes begin where they are and end anywhere.

    Parameters
    ----------
    starts : (n, m) array of int
        Cost of each robot to each target, in whole units; `UNREACHABLE` or more: no way.
    between : (m, m) array of int
        Cost from each target to each other one.
    allowed : (n, m) array of bool, optional
        Which robots may go to which targets; all by default.
    before : (n,) array of int, optional
        What each robot has to drive before its route begins; 0 by default.

    Returns
    -------
    SharedRoutes

    Raises
    ------
    InvalidInputError
        If the arrays do not fit each other, or there is no robot.

    Notes
    -----
    Each time the target is inserted that lengthens the longest route least, where it does so; of
    equal insertions the one that lengthens its own route least, then that of the lower robot, of
    the lower target, and at the earlier place. Then targets are moved one by one while that
    shortens the longest route, or with an equal one the sum of all. Numbers are whole, so that the
    result depends on no rounding. Cost: O(n m^4), for a dozen targets.

    Source: the routes of M-TARE (`caochao39/mtare_planner`), a vehicle routing problem with open
    routes that OR-tools solves within a limit of time. Differs in: insertion and moves of single
    targets, as a limit of time is not repeatable.

    Examples
    --------
    Two robots on a line at 0 and 10, and targets at 1, 2, and 9:

    >>> at, targets = np.array([0, 10]), np.array([1, 2, 9])
    >>> far = lambda a, b: abs(a[:, None] - b)
    >>> shared_routes(far(at, targets), far(targets, targets))
    SharedRoutes(routes=((0, 1), (2,)), left_out=(), longest=2)
    >>> only_first = [[True, True, True], [False, False, False]]
    >>> shared_routes(far(at, targets), far(targets, targets), allowed=only_first).longest
    9
    """
    S, B = np.asarray(starts, np.int64), np.asarray(between, np.int64)
    n, m = S.shape if S.ndim == 2 else (0, 0)
    may = np.ones((n, m), np.bool_) if allowed is None else np.asarray(allowed, np.bool_)
    first = np.zeros(n, np.int64) if before is None else np.asarray(before, np.int64)
    if n < 1 or B.shape != (m, m) or may.shape != (n, m) or first.shape != (n,):
        raise InvalidInputError(
            f"costs of shapes {S.shape} and {B.shape}, {may.shape} allowed and {first.shape} "
            "before do not fit: (n, m), (m, m), (n, m) and (n,) are needed"
        )
    problem = _Problem(S.tolist(), B.tolist(), may.tolist(), first.tolist())
    tours: list[Tour] = [[] for _ in range(n)]
    remaining = list(range(m))
    while (best := problem.best_insertion(tours, remaining)) is not None:
        robot, place, target = best
        tours[robot].insert(place, target)
        remaining.remove(target)
    for _ in range(MAX_PASSES):
        if not problem.move_one(tours):
            break
    return SharedRoutes(
        routes=tuple(map(tuple, tours)),
        left_out=tuple(remaining),
        longest=max(problem.length(i, tour) for i, tour in enumerate(tours)),
    )


class _Problem:
    """The costs, as lists of whole numbers."""

    def __init__(
        self,
        starts: list[list[int]],
        between: list[list[int]],
        may: list[list[bool]],
        first: list[int],
    ) -> None:
        self._starts, self._between = starts, between
        self._may, self._first = may, first

    def length(self, robot: int, tour: Tour) -> int:
        if not tour:
            # Who goes nowhere has nothing to drive before.
            return 0
        way = self._first[robot] + self._starts[robot][tour[0]]
        return way + sum(self._between[a][b] for a, b in pairwise(tour))

    def best_insertion(self, tours: list[Tour], targets: list[int]) -> tuple[int, int, int] | None:
        lengths = [self.length(i, tour) for i, tour in enumerate(tours)]
        best: tuple[int, int, int, int, int] | None = None
        for i, tour in enumerate(tours):
            others = max((m for k, m in enumerate(lengths) if k != i), default=0)
            for target in targets:
                if not self._may[i][target]:
                    continue
                for place in range(len(tour) + 1):
                    longer = self.length(i, [*tour[:place], target, *tour[place:]])
                    if longer >= UNREACHABLE:
                        continue
                    found = max(others, longer), longer - lengths[i], i, target, place
                    if best is None or found < best:
                        best = found
        return None if best is None else (best[2], best[4], best[3])

    def move_one(self, tours: list[Tour]) -> bool:
        lengths = [self.length(i, tour) for i, tour in enumerate(tours)]
        now = max(lengths), sum(lengths)
        for i, tour in enumerate(tours):
            for target in list(tour):
                rest = [t for t in tour if t != target]
                for j in range(len(tours)):
                    if not self._may[j][target]:
                        continue
                    into = rest if j == i else tours[j]
                    for place in range(len(into) + 1):
                        changed = dict(enumerate(tours))
                        changed[i] = rest
                        changed[j] = [*into[:place], target, *into[place:]]
                        after = [self.length(k, changed[k]) for k in range(len(tours))]
                        if (max(after), sum(after)) < now:
                            tours[:] = [changed[k] for k in range(len(tours))]
                            return True
        return False
