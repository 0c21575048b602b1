"""Events that the simulation records: what robots did, whatever they say of it."""

from __future__ import annotations

from typing import Literal

from multisrt.events.event import Event, NodeName, Pose, Segment

Purpose = Literal["explore", "support", "home", "give way"]
"""Why a robot moves; see `Motion`."""


class Motion(Event, frozen=True, kw_only=True, tag="motion"):
    """A robot moved; `time_s` is when it set out. It is recorded when the motion ends.

    Attributes
    ----------
    waypoints : tuple of (time_s, x, y, heading)
        Times are from the start of the run and never fall. Between two waypoints the body moves
        with a constant twist: straight where the heading stays, in place where the position
        stays, else on a circular arc. Headings are not wrapped, so turns are signed.
    purpose : {"explore", "support", "home", "give way"}
        For its own tree (or any goal of a robot that bids for frontiers); for the tree of another
        robot, or in pursuit of a teammate that is out of touch; back to its root, home with data,
        to meet the partner of its pair, or to its place in a chain of relays; or out of the way of
        another robot.
    """

    waypoints: tuple[tuple[float, float, float, float], ...]
    purpose: Purpose = "explore"


class Sensed(Event, frozen=True, kw_only=True, tag="sensed"):
    """A range finder took a scan, whatever the robot did with it; recorded by the simulation.

    Attributes
    ----------
    configuration : (x, y, heading)
        Where the robot was.
    """

    configuration: Pose


class Sent(Event, frozen=True, kw_only=True, tag="sent"):
    """A robot, or the base station, sent a message.

    The number of the base station is that of robots in the team: it comes after the last robot.

    Attributes
    ----------
    kind : str
        The type of the message.
    size_bytes : int
        Its size.
    reached : tuple of int
        Robots to which it is delivered, perhaps with the base station.
    lost : tuple of int
        Robots in reach to which it is lost, perhaps with the base station.
    """

    kind: str
    size_bytes: int
    reached: tuple[int, ...] = ()
    lost: tuple[int, ...] = ()


class BaseLearned(Event, frozen=True, kw_only=True, tag="base_learned"):
    """The base station learned of nodes, by a message of the robot.

    Attributes
    ----------
    nodes : tuple of (robot, serial)
        The nodes that were new to it.
    """

    nodes: tuple[NodeName, ...]


class Blocked(Event, frozen=True, kw_only=True, tag="blocked"):
    """A protective stop ended the motion of a robot, as another body came too near.

    Attributes
    ----------
    by : int
        The robot whose body came too near.
    configuration : (x, y, heading)
        Where the robot stopped.
    """

    by: int
    configuration: Pose


class Died(Event, frozen=True, kw_only=True, tag="died"):
    """A robot died; its body stays where it is.

    Attributes
    ----------
    configuration : (x, y, heading)
        Where it died.
    doing : {"moving", "waiting", "master"}
        What it was doing: moving, standing, or organising a group as its master.
    """

    configuration: Pose
    doing: Literal["moving", "waiting", "master"]


class FellSilent(Event, frozen=True, kw_only=True, tag="fell_silent"):
    """The radio of a robot failed: it neither sends nor receives. The robot goes on."""


class CameBack(Event, frozen=True, kw_only=True, tag="came_back"):
    """The radio of a robot works again."""


class Joined(Event, frozen=True, kw_only=True, tag="joined"):
    """A robot that starts late was switched on."""


class Collision(Event, frozen=True, kw_only=True, tag="collision"):
    """A body touched an obstacle or another body: a defect, which ends the run.

    Attributes
    ----------
    configuration : (x, y, heading)
        Where the robot was: at the start of the leg that touches an obstacle, or at contact with
        another body.
    account : str
        What it touched, in words.
    """

    configuration: tuple[float, float, float]
    account: str


class Ended(Event, frozen=True, kw_only=True, tag="ended"):
    """A robot is done. A robot that is called on ends again, and its last end counts.

    Attributes
    ----------
    reason : str
        Why it ended, in words.
    complete : bool
        Whether it left no frontier that it could reach if no other body blocked its path.
    frontier : tuple of (x0, y0, x1, y1)
        The frontier segments that it left open.
    """

    reason: str
    complete: bool
    frontier: tuple[Segment, ...]
