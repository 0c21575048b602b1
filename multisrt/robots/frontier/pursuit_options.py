"""Parameters of robots that go after a mate that is out of touch."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import msgspec

from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.homing.options import HomingOptions

if TYPE_CHECKING:
    from multisrt.spec import RunSpec


class PursuitOptions(HomingOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Whether and how robots go after mates: those of `HomingOptions`, and these.

    The defaults are those of M-TARE; see `multisrt.planners.pursuit`.

    Attributes
    ----------
    pursue : bool
        Whether a robot goes after a mate that is out of touch, along the route that it told, when
        that shortens the longest route of the team. Needs a team whose radio is limited.
    pursue_gain : float
        Share by which the longest route has to get shorter, from 0 (M-TARE: any) to below 1.
    pursue_stay : float
        Probability that the mate stays at its place on the route in a step.
    pursue_leave : float
        Probability that the mate leaves the route in a step.
    pursue_step_s : float
        Length of a step in seconds; also the minimum time between two looks for a mate to pursue.
    pursue_steps : int
        Number of steps after a mate's last report within which it may be met.
    pursue_wait_s : float
        For how long, after the time of the meeting, a robot waits for the mate, in seconds.
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
            ("pursue_leave", 0.0 <= leave <= 1.0 - stay, "from 0 to 1 - pursue_stay"),
            ("pursue_step_s", 0.0 < self.pursue_step_s < math.inf, "positive"),
            ("pursue_steps", self.pursue_steps >= 1, "at least 1"),
            ("pursue_wait_s", 0.0 < self.pursue_wait_s < math.inf, "positive"),
        ):
            if not holds:
                raise InvalidInputError(f"{name} is {getattr(self, name)}; it must be {allowed}")


def require_pursuit(
    spec: RunSpec, kind: type[msgspec.Struct], options: Mapping[str, object]
) -> None:
    """Check that a run has what robots need that are to pursue their mates.

    Parameters
    ----------
    spec : RunSpec
        The run.
    kind : type
        The structure of its strategy's options; those that are no `PursuitOptions` are passed over.
    options : mapping of str to object
        Their values, as they are given.

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
    multisrt.geometry.errors.InvalidInputError: option pursue of minpos needs mates to go after, \
and there is one robot: give more, or leave it out
    """
    if not issubclass(kind, PursuitOptions):
        return
    defaults = {field.name: field.default for field in msgspec.structs.fields(kind)}
    if str(options.get("pursue", defaults["pursue"])).lower() not in ("true", "1"):
        return
    if len(spec.robots) == 1:
        raise InvalidInputError(
            f"option pursue of {spec.strategy} needs mates to go after, and there is one robot: "
            "give more, or leave it out"
        )
    if spec.radio.reaches_everywhere:
        raise InvalidInputError(
            f"option pursue of {spec.strategy} is for robots that can be out of touch, and this "
            "radio reaches all: limit its range, or leave the option out"
        )
