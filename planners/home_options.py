"""Parameters of robots that can return data to a base station, whatever their strategy is."""

from __future__ import annotations

import math
from typing import Final, Literal

import msgspec

from multisrt.geometry.errors import InvalidInputError

Home = Literal["never", "in-time", "worth", "relays", "chain"]

NO_TIME_LEFT: Final = "no time is left for another"
"""Beginning of the reason that a robot records when it ends because no time is left."""


class HomeOptions(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When robots deliver their data to the base station, and how travel times are estimated.

    Attributes
    ----------
    home : {"never", "in-time", "worth", "relays", "chain"}
        When a robot drives to where the base station hears it. "never": never. "in-time": when
        nothing is left to explore, or early enough to deliver its data before the time limit.
        "worth": then, and when the trip is worthwhile (`home_ratio`). "relays": robots go in pairs,
        of which one explores and the other carries its data home. "chain": robots line up as
        relays, so that the base station hears the one that explores. Other values than "never" need
        a base station.
    home_margin : float
        Margin on the travel time home at full speed, as a share of it, for turns, scans and other
        robots on the path.
    home_reserve_s : float
        Time in seconds to be left at home for the delivery, and for delays that do not depend on
        the path.
    home_ratio : float
        "worth", and "relays" for a robot without a partner: a robot goes home when the area
        acknowledged by the base station is less than this share of the area that the robot knows.
    home_wait_s : float
        Time in seconds for which a robot waits for an acknowledgement where it should be heard,
        with "relays" for its partner after the agreed time, and with "chain" for a relay that is
        late, or for the front that is not heard.

    Raises
    ------
    InvalidInputError
        If a value is outside its range.

    Examples
    --------
    >>> HomeOptions(home_margin=-1.0)
    Traceback (most recent call last):
    ...
    multisrt.geometry.errors.InvalidInputError: home_margin is -1.0; it must be 0 or more
    """

    home: Home = "never"
    home_margin: float = 0.25
    home_reserve_s: float = 10.0
    home_ratio: float = 0.8
    home_wait_s: float = 30.0

    def __post_init__(self) -> None:
        for name, holds, allowed in (
            ("home_margin", 0.0 <= self.home_margin < math.inf, "0 or more"),
            ("home_reserve_s", 0.0 <= self.home_reserve_s < math.inf, "0 or more"),
            ("home_ratio", 0.0 < self.home_ratio < 1.0, "above 0 and below 1"),
            ("home_wait_s", 0.0 < self.home_wait_s < math.inf, "positive"),
        ):
            if not holds:
                raise InvalidInputError(f"{name} is {getattr(self, name)}; it must be {allowed}")
