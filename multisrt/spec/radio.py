"""The radio of a team."""

from __future__ import annotations

import math
from typing import Literal

from multisrt.geometry.errors import InvalidInputError
from multisrt.spec.part import Part


class RadioSpec(Part, frozen=True, kw_only=True):
    """The radio: range, relaying, delay, loss and the effect of walls.

    Attributes
    ----------
    range_m : float or None
        Range of the radio without walls, in metres (paper: R_c); None for an unlimited range.
    multi_hop : bool
        Whether robots relay messages.
    latency_s : float
        Time in seconds that a message takes, relayed or not.
    jitter_s : float
        Upper bound of an additional delay in seconds, drawn uniformly for each message and
        receiver.
    loss : float
        Probability, 0 <= loss < 1, that a message is lost; drawn for each receiver.
    walls : {"pass", "block", "weaken"}
        Whether a wall between two robots has no effect, breaks the link, or weakens the signal.
    path_loss_exponent : float
        Exponent of the path loss if walls weaken; at `range_m` the signal is just sufficient.
    wall_loss_db : float
        Attenuation by one wall if walls weaken, in decibels.

    Raises
    ------
    InvalidInputError
        If a number is out of range, or walls weaken a signal of unlimited range.

    Examples
    --------
    >>> RadioSpec(range_m=12.0, walls="block", loss=0.1).multi_hop
    True
    """

    range_m: float | None = None
    multi_hop: bool = True
    latency_s: float = 0.0
    jitter_s: float = 0.0
    loss: float = 0.0
    walls: Literal["pass", "block", "weaken"] = "pass"
    path_loss_exponent: float = 2.0
    wall_loss_db: float = 5.0

    @property
    def reach_m(self) -> float:
        """Range of the radio without walls, in metres; inf if it is unlimited."""
        return math.inf if self.range_m is None else self.range_m

    @property
    def walls_matter(self) -> bool:
        """Whether walls break links, or shorten them."""
        return self.walls != "pass"

    @property
    def reaches_everywhere(self) -> bool:
        """Whether messages reach all robots despite distance and walls; they may still be lost."""
        return self.range_m is None and not self.walls_matter

    def __post_init__(self) -> None:
        for name, ok, allowed in (
            ("range_m", self.range_m is None or 0.0 <= self.range_m < math.inf, "0 or more"),
            ("latency_s", 0.0 <= self.latency_s < math.inf, "0 or more"),
            ("jitter_s", 0.0 <= self.jitter_s < math.inf, "0 or more"),
            ("loss", 0.0 <= self.loss < 1.0, "from 0 to below 1"),
            ("path_loss_exponent", 1.0 <= self.path_loss_exponent <= 10.0, "from 1 to 10"),
            ("wall_loss_db", 0.0 <= self.wall_loss_db < math.inf, "0 or more"),
        ):
            if not ok:
                raise InvalidInputError(
                    f"{name} of a radio is {getattr(self, name)}; it must be {allowed}"
                )
        if self.walls == "weaken" and self.range_m is None:
            raise InvalidInputError(
                "walls weaken a signal that has a range: give range_m, or let walls pass or block"
            )
