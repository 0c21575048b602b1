"""Groups of robots that step together: connected components of a symmetric relation.

Source: Multi-SRT, paper section 2, "Construction of GPR/GER". Two robots are GPR-coupled when
their targets are nearer than twice the range of perception; the target of a robot that stands
is its own configuration. The GPR of a robot is its connected component under this relation. The
GER is the component under the overlap of local safe regions, once all of the GPR have perceived.
Both relations are symmetric, so every member finds the same group.

Differs in: the path of a moving robot that passes within the sensing range of another's target
without ending there couples the two, too; and for unlike robots twice the range is the sum of
theirs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TypeVar

from multisrt.robots.multi_srt.messages import Path, RobotState

Member = TypeVar("Member")


def are_coupled(a: RobotState, b: RobotState) -> bool:
    """Return whether two robots may meet in their next steps (paper: GPR-coupled).

    They are when their targets are nearer to one another than the sum of their sensing ranges
    (``2 R_p`` for equal robots). Differs in: a moving robot is also coupled to one whose target its
    path passes within sensing range, as a path that is not straight may.
    """
    target_a, target_b = a.target, b.target
    return (
        math.dist(target_a, target_b) < a.range_m + b.range_m
        or (a.phase == "moving" and _passes_near(a.path, target_b, b.range_m))
        or (b.phase == "moving" and _passes_near(b.path, target_a, a.range_m))
    )


def _passes_near(path: Path, place: tuple[float, float], range_m: float) -> bool:
    # The innermost loop of the groups: a generator expression takes twice as long.
    for _, x, y, _ in path:  # noqa: SIM110
        if math.dist((x, y), place) < range_m:
            return True
    return False


def group_of(
    number: int, members: Mapping[int, Member], coupled: Callable[[Member, Member], bool]
) -> tuple[int, ...]:
    """Return the connected component of a robot under a symmetric relation.

    Parameters
    ----------
    number : int
        The robot; a key of `members`.
    members : mapping of int to object
        What the relation compares, by the number of the robot.
    coupled : callable
        The relation.

    Returns
    -------
    tuple of int
        The members of the component in rising order, `number` among them.

    Examples
    --------
    >>> places = {0: 0.0, 1: 1.0, 2: 2.0, 3: 5.0}
    >>> group_of(0, places, lambda a, b: abs(a - b) < 1.5)
    (0, 1, 2)
    """
    group = [number]
    rest = [other for other in sorted(members) if other != number]
    for one in group:
        if not rest:
            break
        near = [other for other in rest if coupled(members[one], members[other])]
        group += near
        rest = [other for other in rest if other not in near]
    return tuple(sorted(group))
