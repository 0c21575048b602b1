"""Options of all strategies whose robots can bring news to a base station."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final, Literal, Protocol

import msgspec

from multisrt.geometry.errors import InvalidInputError

if TYPE_CHECKING:
    from multisrt.spec import RunSpec

Home = Literal["never", "in-time", "worth", "relays"]

EXCHANGE_MESSAGES: Final = 4
"""A report, a question for what is missing, the answer, and its acknowledgement."""


HOME_FIELDS: Final = frozenset(
    {"home", "home_margin", "home_reserve_s", "home_ratio", "home_wait_s"}
)
"""Options that all strategies have that can bring news home."""


class HomingOptions(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When robots bring home what they know.

    Attributes
    ----------
    home : {"never", "in-time", "worth", "relays"}
        When a robot drives to where the base station hears it. "never": on no account. "in-time":
        when it has explored all it can, and so that what it carries is delivered before the run's
        time limit. "worth": then, and when what it carries is worth the way. "relays": robots go
        in pairs, of which one explores and the other carries its news home. Other values than
        "never" need a base station.
    home_margin : float
        Share by which ways home are taken to last longer than their length at full speed, for
        turns, scans and other robots on the way.
    home_reserve_s : float
        Time in seconds that is to be left at home for the delivery, and for delays that do not
        depend on the way.
    home_ratio : float
        "worth": a robot goes home when the area that the base station knows is less than this
        share of that area and the one it does not know yet.
    home_wait_s : float
        Time in seconds for which a robot waits for an acknowledgement where it should be heard,
        and, with "relays", for its mate after the time agreed on.
    home_period_s : float
        "relays": minimum time in seconds between two meetings of a pair.
    """

    home: Home = "never"
    home_margin: float = 0.25
    home_reserve_s: float = 10.0
    home_ratio: float = 0.8
    home_wait_s: float = 30.0
    home_period_s: float = 60.0

    def __post_init__(self) -> None:
        require_home_values(self)
        if not 0.0 < self.home_period_s < math.inf:
            raise InvalidInputError(f"home_period_s is {self.home_period_s}; it must be positive")


class HomeValues(Protocol):
    """What the options of all strategies have that bring news home."""

    @property
    def home_margin(self) -> float:
        """Share by which ways home last longer."""

    @property
    def home_reserve_s(self) -> float:
        """Time that is to be left at home."""

    @property
    def home_ratio(self) -> float:
        """Share that the base station is to know of what a robot knows."""

    @property
    def home_wait_s(self) -> float:
        """Time for which a robot waits."""


def require_home_values(options: HomeValues) -> None:
    """Check the values of options.

    Raises
    ------
    InvalidInputError
        If one is not allowed; the message names it.
    """
    for name, holds, allowed in (
        ("home_margin", 0.0 <= options.home_margin < math.inf, "0 or more"),
        ("home_reserve_s", 0.0 <= options.home_reserve_s < math.inf, "0 or more"),
        ("home_ratio", 0.0 < options.home_ratio < 1.0, "between 0 and 1"),
        ("home_wait_s", 0.0 < options.home_wait_s < math.inf, "positive"),
    ):
        if not holds:
            raise InvalidInputError(f"{name} is {getattr(options, name)}; it must be {allowed}")


def require_home(spec: RunSpec, kind: type[msgspec.Struct], options: Mapping[str, object]) -> None:
    """Check that a run has what robots need that are to bring news home.

    Parameters
    ----------
    spec : RunSpec
        The run.
    kind : type
        The structure of its strategy's options; those without `home` and its values are passed
        over.
    options : mapping of str to object
        Their values, as they are given.

    Raises
    ------
    InvalidInputError
        If it has no base station; or, for "relays", a single robot.

    Examples
    --------
    >>> from multisrt.spec import CatalogEnvironment, RunSpec
    >>> spec = RunSpec(environment=CatalogEnvironment(name="open"), strategy="minpos")
    >>> require_home(spec, HomingOptions, {"home": "in-time"})
    Traceback (most recent call last):
    ...
    multisrt.geometry.errors.InvalidInputError: option home='in-time' of minpos needs a base \
station to bring news to: give its place, base=(x, y) or --base X,Y
    """
    defaults = {field.name: field.default for field in msgspec.structs.fields(kind)}
    if not defaults.keys() >= HOME_FIELDS:
        return
    home = options.get("home", defaults["home"])
    if home == "never":
        return
    if spec.base is None:
        raise InvalidInputError(
            f"option home={home!r} of {spec.strategy} needs a base station to bring news to: "
            "give its place, base=(x, y) or --base X,Y"
        )
    if home == "relays" and len(spec.robots) == 1:
        raise InvalidInputError(
            f"option home='relays' of {spec.strategy} needs pairs of robots, and there is one "
            "robot: give more, or home='worth'"
        )
