"""Parameters of robots that pursue teammates that are out of touch."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import msgspec

from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.homing.options import HomingOptions

if TYPE_CHECKING:
    from multisrt.spec import RunSpec

ROUNDING = 1e-9
"""By how much probabilities that add up to one may exceed it."""


class PursuitOptions(HomingOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of robots that may pursue teammates: those of `HomingOptions`, and these.

    The defaults are those of M-TARE; see `multisrt.planners.pursuit`.

    Attributes
    ----------
    pursue : bool
        Whether a robot pursues a teammate that is out of touch, along the route that the teammate
        reported, when that reduces the cost of the team's routes: the longest plus a tenth of the
        mean. Needs a team whose radio is limited.
    pursue_gain : float
        Share by which the cost of the team's routes must fall, from 0 to below 1; at least 1 m in
        any case.
    pursue_stay : float
        Probability that the teammate stays at its place on its route in a step.
    pursue_leave : float
        Probability that the teammate leaves its route in a step.
    pursue_step_s : float
        Length of a step in seconds; also the minimum time between two decisions whether to pursue.
    pursue_steps : int
        Number of steps after the teammate's last report within which it may be met.
    pursue_wait_s : float
        Time in seconds for which a robot waits for the teammate after the time of the meeting.
    """

    pursue: bool = False
    pursue_gain: float = 0.0
    pursue_stay: float = 0.35
    pursue_leave: float = 0.15
    pursue_step_s: float = 6.0
    pursue_steps: int = 100
    pursue_wait_s: float = 12.0

    def __post_init__(self) -> None:
        super().__post_init__()
        stay, leave = self.pursue_stay, self.pursue_leave
        for name, holds, allowed in (
            ("pursue_gain", 0.0 <= self.pursue_gain < 1.0, "from 0 to below 1"),
            ("pursue_stay", 0.0 <= stay <= 1.0, "from 0 to 1"),
            ("pursue_leave", 0.0 <= leave <= 1.0 - stay + ROUNDING, "from 0 to 1 - pursue_stay"),
            ("pursue_step_s", 0.0 < self.pursue_step_s < math.inf, "positive"),
            ("pursue_steps", self.pursue_steps >= 1, "at least 1"),
            ("pursue_wait_s", 0.0 < self.pursue_wait_s < math.inf, "positive"),
        ):
            if not holds:
                raise InvalidInputError(f"{name} is {getattr(self, name)}; it must be {allowed}")


def require_pursuit(
    spec: RunSpec, kind: type[msgspec.Struct], options: Mapping[str, object]
) -> None:
    """Check that a run has what the option `pursue` needs.

    Parameters
    ----------
    spec : RunSpec
        The run.
    kind : type
        The structure of its strategy's options; those that are no `PursuitOptions` are ignored.
    options : mapping of str to object
        Their values, as given.

    Raises
    ------
    InvalidInputError
        If there is a single robot, or the radio reaches all wherever they are.

    Examples
    --------
    >>> from multisrt.spec import CatalogEnvironment, RunSpec
    >>> spec = RunSpec(environment=CatalogEnvironment(name="open"), strategy="minpos")
    >>> require_pursuit(spec, PursuitOptions, {"pursue": True})
    Traceback (most recent call last):
    ...
    multisrt.geometry.errors.InvalidInputError: option pursue of minpos needs teammates to pursue, \
and there is one robot: give more, or leave it out
    """
    if not issubclass(kind, PursuitOptions):
        return
    defaults = {field.name: field.default for field in msgspec.structs.fields(kind)}
    if str(options.get("pursue", defaults["pursue"])).lower() not in ("true", "1"):
        return
    if len(spec.robots) == 1:
        raise InvalidInputError(
            f"option pursue of {spec.strategy} needs teammates to pursue, and there is one robot: "
            "give more, or leave it out"
        )
    if spec.radio.reaches_everywhere:
        raise InvalidInputError(
            f"option pursue of {spec.strategy} is for robots that can be out of touch, and this "
            "radio reaches all: limit its range, or leave the option out"
        )
