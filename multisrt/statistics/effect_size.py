"""Effect size: how much two sets of runs differ, whatever their number."""

from __future__ import annotations

from typing import Literal

from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.statistics.samples import sample_of
from multisrt.statistics.wins import share_of_wins

Magnitude = Literal["negligible", "small", "medium", "large"]

SMALL, MEDIUM, LARGE = 0.56, 0.64, 0.71
"""Lower bounds of Vargha and Delaney's magnitudes, for the larger of A and 1 - A."""


def vargha_delaney(a: ArrayLike, b: ArrayLike) -> float:
    """Return the probability that a value of `a` is lower than one of `b`.

    Source: Vargha and Delaney, A critique and improvement of the CL common language effect size
    statistics of McGraw and Wong, Journal of Educational and Behavioral Statistics 25, 2000;
    differs in: their A is the probability of being higher, theirs of (b, a) is this of (a, b).

    Parameters
    ----------
    a, b : array_like, shapes (n,) and (m,)
        Values of runs; infinite ones are tied.

    Returns
    -------
    float
        From 0 (all of `b` are lower) to 1 (all of `a` are lower); 0.5 if neither tends to be.
        Ties count half.

    Raises
    ------
    InvalidInputError
        If one is empty or holds nan.

    Examples
    --------
    >>> vargha_delaney([1.0, 2.0], [2.0, 3.0])
    0.875
    """
    return share_of_wins(sample_of(a, "a"), sample_of(b, "b"))


def magnitude(share: float) -> Magnitude:
    """Return Vargha and Delaney's word for an effect size.

    Parameters
    ----------
    share : float
        An effect size A from 0 to 1; A and 1 - A have the same magnitude.

    Returns
    -------
    {"negligible", "small", "medium", "large"}
        The magnitude.

    Raises
    ------
    InvalidInputError
        If the share is not from 0 to 1.

    Examples
    --------
    >>> magnitude(0.875), magnitude(0.42)
    ('large', 'small')
    """
    if not 0.0 <= share <= 1.0:
        raise InvalidInputError(f"an effect size A is from 0 to 1, not {share}")
    # Rounded, so that 1 - A of a bound is the bound itself.
    larger = round(max(share, 1.0 - share), 12)
    if larger < SMALL:
        return "negligible"
    if larger < MEDIUM:
        return "small"
    return "medium" if larger < LARGE else "large"
