"""Options of the informed plan."""

from __future__ import annotations

from typing import Annotated

import msgspec


class InformedOptions(msgspec.Struct, frozen=True, kw_only=True):
    """Options of the strategy `informed`.

    Attributes
    ----------
    share : float
        Share of what the team can see that it is to see, from 0.1 to 1. All robots end when it is
        reached.
    home : bool
        Whether each robot drives back to its start in the end.
    effort : float
        How long the plan is improved, as a share of the usual, from 0 to 100.
    """

    share: Annotated[float, msgspec.Meta(ge=0.1, le=1.0)] = 0.99
    home: bool = False
    effort: Annotated[float, msgspec.Meta(ge=0.0, le=100.0)] = 1.0
