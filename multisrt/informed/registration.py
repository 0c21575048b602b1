"""The strategy `informed`, as the registry loads it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.informed.options import InformedOptions
from multisrt.planners.motion.kinematics import Car
from multisrt.robots.explorer import Explorer, RobotSelf
from multisrt.robots.strategy import Strategy
from multisrt.spec import Death, LateStart, RunSpec


def _explorer(me: RobotSelf, options: InformedOptions) -> Explorer:
    from multisrt.informed.explorer import InformedExplorer

    return InformedExplorer(me, options)


def _plan(
    spec: RunSpec, environment: Any, starts: Sequence[Configuration], progress: Any
) -> tuple[object, ...]:
    from multisrt.informed.plan import plan

    return plan(spec, environment, starts, progress)


def _require_fit(spec: RunSpec) -> None:
    for number, robot in enumerate(spec.robots):
        if isinstance(robot.drive.kinematics(), Car):
            raise InvalidInputError(
                f"robot {number} is a car, for which informed makes no plan; give it a holonomic "
                "or differential drive"
            )
    for fault in spec.faults:
        if isinstance(fault, Death | LateStart):
            raise InvalidInputError(
                f"informed requires that all robots begin at time 0 and survive, which robot "
                f"{fault.robot} does not; remove the fault"
            )


INFORMED = Strategy(
    name="informed",
    summary="Reference: follows routes planned on the true map",
    options=InformedOptions,
    explorer=_explorer,
    fits=_require_fit,
    plan=_plan,
)
"""The only strategy that sees the truth."""
