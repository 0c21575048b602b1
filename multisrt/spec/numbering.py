"""Texts about the numbers of the robots of a team."""

from __future__ import annotations


def numbers_of(robots: int) -> str:
    """Return the numbers of the robots of a team as text, for messages about a missing one.

    Parameters
    ----------
    robots : int
        Number of robots in the team.

    Returns
    -------
    str
        A clause without a full stop.

    Examples
    --------
    >>> numbers_of(1)
    'the team has one robot, number 0'
    >>> numbers_of(3)
    'the team has 3 robots, numbered 0 to 2'
    """
    if robots == 1:
        return "the team has one robot, number 0"
    return f"the team has {robots} robots, numbered 0 to {robots - 1}"


def missing(robot: int, robots: int) -> str:
    """Return a message that a team has no robot with a number, and which numbers it has.

    Parameters
    ----------
    robot : int
        The number.
    robots : int
        Number of robots in the team.

    Returns
    -------
    str
        A clause without a full stop.

    Examples
    --------
    >>> missing(3, 3)
    'there is no robot 3: the team has 3 robots, numbered 0 to 2'
    """
    return f"there is no robot {robot}: {numbers_of(robots)}"
