"""Robots in sentences: `robot 2`, `robots 1, 2 and 4`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final


def named_robots(numbers: Iterable[int]) -> str:
    """Return robots as text, by their numbers.

    Parameters
    ----------
    numbers : iterable of int
        The numbers, at least one; they are listed in ascending order.

    Returns
    -------
    str
        ``robot`` or ``robots`` and the numbers.

    Examples
    --------
    >>> named_robots([2]), named_robots({4, 1}), named_robots([0, 1, 2])
    ('robot 2', 'robots 1 and 4', 'robots 0, 1 and 2')
    """
    words = [str(number) for number in sorted(numbers)]
    return f"robot{'s' * (len(words) > 1)} {joined(words)}"


NO_CHAIN: Final = "no goal is left from which the chain reaches the base station"
"""Reason of a robot that ends because its chain of relays is too short."""

BOXED_IN: Final = "boxed in"
"""Beginning of the reason of a robot that ends because others, or walls, block all of its paths."""

WALLED_IN: Final = f"{BOXED_IN} at the start, where the scan shows no way for the body"
"""The reason of a robot that ends where it began, as it finds no motion from there."""


def boxed_in_by(numbers: Iterable[int]) -> str:
    """Return the reason of a robot that ends because others block all of its paths.

    Parameters
    ----------
    numbers : iterable of int
        The others; none where walls alone leave it no path.

    Returns
    -------
    str
        The reason.

    Examples
    --------
    >>> boxed_in_by([2])
    'boxed in by robot 2, which does not give way'
    >>> boxed_in_by([2, 0])
    'boxed in by robots 0 and 2, which do not give way'
    >>> boxed_in_by([])
    'boxed in'
    """
    others = list(numbers)
    if not others:
        return BOXED_IN
    do = "does" if len(others) == 1 else "do"
    return f"{BOXED_IN} by {named_robots(others)}, which {do} not give way"


def joined(words: Sequence[str]) -> str:
    """Return words as a list in a sentence.

    Parameters
    ----------
    words : sequence of str
        At least one.

    Returns
    -------
    str
        The words, with commas and ``and`` between them.

    Examples
    --------
    >>> joined(["star"]), joined(["star", "ball"]), joined(["star", "ball", "radial"])
    ('star', 'star and ball', 'star, ball and radial')
    """
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
