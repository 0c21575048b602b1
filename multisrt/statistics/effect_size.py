"""How much one set of runs differs from another, whatever the number of runs."""

from __future__ import annotations

from typing import Literal

from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.statistics.samples import sample_of
from multisrt.statistics.wins import share_of_wins

Magnitude = Literal["negligible", "small", "medium", "large"]

SMALL, MEDIUM, LARGE = 0.56, 0.64, 0.71
"""Where Vargha and Delaney draw the lines, for A or 1 - A, whichever is larger."""


def vargha_delaney(a: ArrayLike, b: ArrayLike) -> float:
    """Probability that a value of `a` is LOWER than one of `b`; ties count half.

    So 1 says that all of `a` are lower, 0 that all of `b` are, and 0.5 that neither tends to be.
    Vargha and Delaney's own A is the probability of being higher: theirs of (b, a) is ours of
    (a, b).

    Parameters
    ----------
    a, b : array_like, shapes (n,) and (m,)
        Values of runs; infinite ones are ties at their end.

    Raises
    ------
    InvalidInputError
        If one is empty or holds nan.

    Source: Vargha and Delaney, A critique and improvement of the CL common language effect size
    statistics of McGraw and Wong, Journal of Educational and Behavioral Statistics 25, 2000.
    """
    return share_of_wins(sample_of(a, "a"), sample_of(b, "b"))


def magnitude(share: float) -> Magnitude:
    """Vargha and Delaney's word for an A, the same for A and 1 - A.

    Raises
    ------
    InvalidInputError
        Unless the share is from 0 to 1.
    """
    if not 0.0 <= share <= 1.0:
        raise InvalidInputError(f"an effect size A is from 0 to 1, not {share}")
    # 1 - A is rounded: a share that is on a line stays there.
    larger = round(max(share, 1.0 - share), 12)
    if larger < SMALL:
        return "negligible"
    if larger < MEDIUM:
        return "small"
    return "medium" if larger < LARGE else "large"
