"""Explorers that follow a script, and checks of them."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pytest
import shapely

from multisrt.environments.environment import Environment
from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.explorer import Done, Move, RobotSelf, Sense
from multisrt.robots.messages import Message
from multisrt.spec import RobotSpec
from multisrt.testing import ExplorerDefect, check_explorer, two_rooms
from multisrt.testing.check import CheckedExplorer

WORLD = two_rooms()
HALL = Environment("hall", shapely.box(0.0, 0.0, 6.0, 6.0))
NOTHING = object()


class Base:
    """An explorer that follows a script; there is a metre of free space ahead of its start."""

    def __init__(self, me: RobotSelf) -> None:
        self.me = me
        self.at = me.start

    def run(self) -> Any:
        """Carry out the script, which may be any iterator, and end."""
        actions = self.act()
        if hasattr(actions, "send"):
            yield from actions
        else:
            while (action := next(actions, NOTHING)) is not NOTHING:
                yield action
        yield Done(complete=True, reason="enough")

    def act(self) -> Iterator[Any]:
        """Yield the actions of the script."""
        yield Sense()

    def to(
        self,
        x: float = 0.0,
        y: float = 0.0,
        heading: float = 0.0,
        seconds: float = 10.0,
        start: Configuration | None = None,
    ) -> Move:
        """Return a motion by a vector and an angle."""
        a = self.at if start is None else start
        end = Waypoint(seconds, a.x + x, a.y + y, a.heading + heading)
        return Move(trajectory=Trajectory((Waypoint(0.0, *a), end)))


def explorer(act: Callable[[Any], Iterator[Any]], **attributes: Any) -> Any:
    """Return an explorer whose script is a function of it, with attributes of its class."""
    return type("Acting", (Base,), {"__module__": act.__module__, "act": act, **attributes})


def check(
    make: Any,
    *,
    world: Environment = HALL,
    teams: Sequence[int] = (1,),
    start: tuple[float, float] = (3.0, 3.0),
    robot: RobotSpec | None = None,
    **more: Any,
) -> CheckedExplorer:
    """Check an explorer in one world; a robot that is alone starts at a given place."""
    usual = RobotSpec(start=start if tuple(teams) == (1,) else None)
    return check_explorer(make, worlds=[world], teams=teams, robot=robot or usual, **more)


def refused(make: Any, match: str, **more: Any) -> ExplorerDefect:
    """Return the defect for which an explorer fails its check."""
    with pytest.raises(ExplorerDefect, match=match) as caught:
        check(make, **more)
    return caught.value


class Hello(Message, frozen=True, kw_only=True):
    """A message with an array."""

    place: np.ndarray
