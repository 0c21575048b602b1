"""Options of all strategies whose robots can return data to a base station."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

import msgspec

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.home_options import HomeOptions

if TYPE_CHECKING:
    from multisrt.spec import RunSpec

EXCHANGE_MESSAGES: Final = 4
"""Number of messages of a delivery: report, question, answer and acknowledgement."""


class HomingOptions(HomeOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of robots that can also form pairs or chains: those of `HomeOptions`, and these.

    Attributes
    ----------
    home_period_s : float
        "relays": minimum time from a meeting of a pair to the next that it agrees on, in seconds.
    home_link : float
        "chain": maximum length of a link between two relays, as a share of the radio's range.
    """

    home_period_s: float = 60.0
    home_link: float = 0.9

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.home_period_s < math.inf:
            raise InvalidInputError(f"home_period_s is {self.home_period_s}; it must be positive")
        if not 0.0 < self.home_link <= 1.0:
            raise InvalidInputError(
                f"home_link is {self.home_link}; it must be above 0 and at most 1"
            )


def require_home(spec: RunSpec, kind: type[msgspec.Struct], options: Mapping[str, object]) -> None:
    """Check that a run has what the option `home` needs.

    Parameters
    ----------
    spec : RunSpec
        The run.
    kind : type
        The structure of its strategy's options; those that are no `HomeOptions` are ignored.
    options : mapping of str to object
        Their values, as given.

    Raises
    ------
    InvalidInputError
        If it has no base station; for "relays" or "chain", a single robot; or for "chain" a radio
        that relays no messages.

    Examples
    --------
    >>> from multisrt.spec import CatalogEnvironment, RunSpec
    >>> spec = RunSpec(environment=CatalogEnvironment(name="open"), strategy="minpos")
    >>> require_home(spec, HomingOptions, {"home": "in-time"})
    Traceback (most recent call last):
    ...
    multisrt.geometry.errors.InvalidInputError: option home='in-time' of minpos needs a base \
station to return data to: give its place, base=(x, y) or --base X,Y
    """
    if not issubclass(kind, HomeOptions):
        return
    defaults = {field.name: field.default for field in msgspec.structs.fields(kind)}
    home = options.get("home", defaults["home"])
    if home == "never":
        return
    if spec.base is None:
        raise InvalidInputError(
            f"option home={home!r} of {spec.strategy} needs a base station to return data to: "
            "give its place, base=(x, y) or --base X,Y"
        )
    if home == "chain" and len(spec.robots) == 1:
        raise InvalidInputError(
            f"option home='chain' of {spec.strategy} needs robots that stand as relays, and there "
            "is one robot: give more, or home='in-time'"
        )
    if home == "chain" and not spec.radio.multi_hop:
        raise InvalidInputError(
            f"option home='chain' of {spec.strategy} needs a radio by which robots relay messages: "
            "set multi_hop to true, or give home='relays'"
        )
    if home == "relays" and len(spec.robots) == 1:
        raise InvalidInputError(
            f"option home='relays' of {spec.strategy} needs pairs of robots, and there is one "
            "robot: give more, or home='worth'"
        )
