"""A run to be judged: its recording and its world, with what several invariants need of them."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, Final, TypeVar

import msgspec
import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.campaign.bodies import Body, FloatArray, bodies_of
from multisrt.campaign.lasers import finds_all
from multisrt.campaign.tracks import Track, tracks
from multisrt.environments.environment import Environment
from multisrt.events import BaseLearned, Died, Ended, Joined, Learned, NodeAdded, NodeName
from multisrt.planners.srt_options import SrtOptions
from multisrt.recording import Recording
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.registry import strategy
from multisrt.spec import Fault, LateStart, Silence

T = TypeVar("T")

Interval = tuple[float, float]
"""Begin and end, in seconds."""

ROUNDING_S: Final = 1e-6
"""Times that differ by less are equal, in seconds."""

ROUNDING_M: Final = 1e-6
"""Lengths that differ by less are equal, in metres."""


@dataclass(frozen=True, slots=True, eq=False)
class Walls:
    """The true free space, and its border as single walls.

    Attributes
    ----------
    free : geometry
        Free space, prepared.
    grown : geometry
        Free space with `ROUNDING_M` of what surrounds it, prepared.
    tree : STRtree
        The walls, as lines of two points.
    """

    free: BaseGeometry
    grown: BaseGeometry
    tree: shapely.STRtree

    def shrunk(self) -> BaseGeometry:
        """Return free space without what is within `ROUNDING_M` of walls, prepared."""
        inner = self.free.buffer(-ROUNDING_M, quad_segs=1)
        shapely.prepare(inner)
        return inner


@dataclass(frozen=True, eq=False, kw_only=True)
class JudgedRun:
    """A run to be judged.

    Attributes
    ----------
    recording : Recording
        What happened.
    environment : Environment
        The world in which it did.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", seed=1, max_time_s=10.0)
    >>> judged = JudgedRun(recording=run.recording, environment=ms.environment("open"))
    >>> len(judged.tracks), judged.present_s(0)
    (1, (0.0, inf))
    """

    recording: Recording
    environment: Environment
    _shared: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False)

    def once(self, name: Hashable, compute: Callable[[], T]) -> T:
        """Return what was computed before under a name; if nothing was, call `compute`."""
        if name not in self._shared:
            self._shared[name] = compute()
        found: T = self._shared[name]
        return found

    @property
    def robots(self) -> range:
        """The numbers of the robots."""
        return range(len(self.recording.spec.robots))

    @property
    def end_s(self) -> float:
        """When the run ended, in seconds."""
        return self.recording.footer.time_s

    @property
    def family(self) -> str:
        """``srt`` for Multi-SRT, ``frontier`` for bidding, ``other`` for all else."""
        name = self.recording.spec.strategy
        if ":" in name:  # of a user, whose rules are not known
            return "other"
        options = strategy(name).options
        if issubclass(options, SrtOptions):
            return "srt"
        return "frontier" if issubclass(options, FrontierOptions) else "other"

    @cached_property
    def options(self) -> Mapping[str, Any]:
        """The options of the strategy, with their defaults."""
        spec = self.recording.spec
        given = msgspec.convert(spec.options, strategy(spec.strategy).options, strict=False)
        return msgspec.structs.asdict(given)

    @property
    def walls(self) -> Walls:
        """The true free space."""
        return walls_of(self.environment)

    @property
    def returns_data(self) -> bool:
        """Whether robots are to go home, so that the base station learns what they know."""
        if self.family == "other" or self.recording.spec.base is None:
            return False
        return bool(self.options["home"] != "never")

    @cached_property
    def beams_find_all(self) -> bool:
        """Whether the range finders of all robots find all obstacles; True for exact sensors."""
        return finds_all(self.recording.spec, self.environment)

    @cached_property
    def bodies(self) -> list[Body]:
        """The body of each robot."""
        return bodies_of(self.recording.spec)

    @cached_property
    def tracks(self) -> list[Track]:
        """The track of each robot."""
        return tracks(self.recording)

    def named(self, member: int) -> str:
        """Return what a robot, or the base station, whose number follows, is called."""
        return "the base station" if member == len(self.robots) else f"robot {member}"

    def present_s(self, robot: int) -> Interval:
        """Return from when to when a robot takes part: it is on, and not dead."""
        return self._present_s[robot]

    @cached_property
    def _present_s(self) -> list[Interval]:
        late = {f.robot for f in self.recording.spec.faults if isinstance(f, LateStart)}
        begins = {joined.robot: joined.time_s for joined in self.recording.of(Joined)}
        ends = {died.robot: died.time_s for died in self.recording.of(Died)}
        return [
            (begins.get(robot, math.inf if robot in late else 0.0), ends.get(robot, math.inf))
            for robot in self.robots
        ]

    @cached_property
    def ends(self) -> dict[int, Ended]:
        """The last end of each robot that has ended."""
        return {end.robot: end for end in self.recording.of(Ended)}

    @cached_property
    def nodes(self) -> dict[NodeName, NodeAdded]:
        """All nodes by name."""
        return {(n.robot, n.serial): n for n in self.recording.of(NodeAdded)}

    @cached_property
    def regions(self) -> dict[NodeName, Polygon]:
        """The region of each node."""
        region = self.recording.region
        return {name: Polygon(region(node)) for name, node in self.nodes.items()}

    @cached_property
    def known(self) -> list[dict[NodeName, float]]:
        """For each robot the nodes that it recorded as known, with the times in seconds."""
        known: list[dict[NodeName, float]] = [{} for _ in self.robots]
        for event in self.recording.events:
            match event:
                case NodeAdded():
                    known[event.robot].setdefault((event.robot, event.serial), event.time_s)
                case Learned():
                    for name in event.nodes:
                        known[event.robot].setdefault((name[0], name[1]), event.time_s)
        return known

    @cached_property
    def base_knows_s(self) -> dict[NodeName, float]:
        """When the base station learned of each node that it knows, in seconds."""
        known: dict[NodeName, float] = {}
        for event in self.recording.of(BaseLearned):
            for name in event.nodes:
                known.setdefault((name[0], name[1]), event.time_s)
        return known

    def component(self, robot: int) -> Polygon:
        """Return the connected part of free space in which a robot starts."""
        return self._components[robot]

    @cached_property
    def _components(self) -> list[Polygon]:
        parts: list[Polygon] = shapely.get_parts(self.environment.free).tolist()
        starts = [shapely.Point(x, y) for x, y, _ in self.recording.header.starts]
        return [min(parts, key=lambda part: float(part.distance(at))) for at in starts]

    def by_robot(self, *kinds: type) -> dict[int, list[Any]]:
        """Return the events of some kinds of each robot, in the order of the recording."""
        found: dict[int, list[Any]] = defaultdict(list)
        for event in self.recording.events:
            if isinstance(event, kinds):
                found[event.robot].append(event)
        return found


def silences(faults: Iterable[Fault], robot: int, since_s: float = 0.0) -> list[Interval]:
    """Return the intervals in which the radio of a robot is to be silent, merged and in order.

    Parameters
    ----------
    faults : iterable of Fault
        The faults of the run.
    robot : int
        The robot.
    since_s : float
        When it is switched on, in seconds.

    Examples
    --------
    >>> faults = [Silence(robot=0, time_s=5.0, duration_s=15.0)]
    >>> silences([*faults, Silence(robot=0, time_s=0.0, duration_s=10.0)], 0)
    [(0.0, 20.0)]
    """
    found: list[Interval] = []
    own = [fault for fault in faults if isinstance(fault, Silence) and fault.robot == robot]
    for fault in sorted(own, key=lambda fault: fault.time_s):
        begin_s, end_s = max(fault.time_s, since_s), fault.time_s + fault.duration_s
        if found and begin_s <= found[-1][1]:
            found[-1] = found[-1][0], max(found[-1][1], end_s)
        elif begin_s < end_s:
            found.append((begin_s, end_s))
    return found


@lru_cache(maxsize=8)
def walls_of(environment: Environment) -> Walls:
    """Return the walls of a world; they are kept for the next run in it."""
    free = shapely.MultiPolygon(environment.free)
    grown = free.buffer(ROUNDING_M, quad_segs=1)
    shapely.prepare(free)
    shapely.prepare(grown)
    return Walls(free=free, grown=grown, tree=shapely.STRtree(segments_of(free)))


def segments_of(area: BaseGeometry) -> list[BaseGeometry]:
    """Return the edges of an area as lines of two points."""
    lines: list[FloatArray] = []
    for ring in shapely.get_rings(shapely.get_parts(area)):
        points = shapely.get_coordinates(ring)
        lines.append(np.stack([points[:-1], points[1:]], axis=1))
    found: list[BaseGeometry] = np.asarray(shapely.linestrings(np.concatenate(lines))).tolist()
    return found
