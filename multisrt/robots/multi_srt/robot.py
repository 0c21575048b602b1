"""One Multi-SRT robot: what it knows, where it is, and the ways that it can go."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from shapely.geometry.base import BaseGeometry

from multisrt.events import ArcClosed, MapComplete, Purpose, Segment, Stage
from multisrt.geometry.bodies.clearance import keep_off
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.distances import inside
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.safe_region import LocalSafeRegion, Shape
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Car
from multisrt.planners.motion.sweep import Sweep
from multisrt.planners.motion.trajectory import Trajectory, Waypoint, standing_at
from multisrt.planners.srt import SrtPlanner
from multisrt.planners.viewing import CLOSE_BY, Refusal, Way, arc_points
from multisrt.robots.exploration_map import Closing, ClosingId, ExplorationMap, Node, NodeId
from multisrt.robots.explorer import Action, Note, Outcome, RobotSelf, Sighting
from multisrt.robots.multi_srt.bypass import Track, first_leg
from multisrt.robots.multi_srt.messages import Order
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.multi_srt.organize import motion_of
from multisrt.robots.multi_srt.team import SAME_PLACE_M, Team
from multisrt.robots.multi_srt.ways import OutAndBack, Ways
from multisrt.robots.protective_stop import BEYOND_GUARD, least_gap

MOST_TRIES = 12
"""After so many tries a robot plans around those who stand in its way; and if it is boxed in,
it gives up."""

Steps = Generator[Action, Outcome, None]
GivenUp = Refusal | Literal["blocked by a robot"]
"""Why an arc is given up."""


@dataclass(frozen=True, slots=True)
class NewPlace:
    """A target without a node.

    Attributes
    ----------
    x, y : float
        The place.
    stage : Stage
        How it was found.
    way : tuple of NodeId
        Nodes to pass on the way, from the current one; the last becomes the parent.
    roomy : bool
        Whether there is room for any heading all along the way from there.
    aim : NodeId or None
        The node whose frontier is to be seen from there.
    """

    x: float
    y: float
    stage: Stage
    way: tuple[NodeId, ...]
    roomy: bool = False
    aim: NodeId | None = None


@dataclass(frozen=True, slots=True)
class KnownNode:
    """A target that is a node, at the end of a way over the roadmap.

    Attributes
    ----------
    way : tuple of NodeId
        From the current node to the target.
    aim : NodeId or None
        The node whose frontier it is about.
    """

    way: tuple[NodeId, ...]
    aim: NodeId | None = None


Target = NewPlace | KnownNode


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """The next motion towards a target.

    Attributes
    ----------
    way : OutAndBack
        What is driven, and for a new place the way back from there.
    node : NodeId or None
        The node at its end; None where there is none yet.
    rest : Target or None
        What is left of the target afterwards.
    parent : NodeId
        The node from which a place without a node is reached.
    stage : Stage
        How such a place was found.
    roomy : bool
        Whether there is room for any heading all along.
    frontier_m : float
        How much frontier the robot goes for.
    purpose : Purpose or None
        Why, if it is not what the robot is at anyway.
    """

    way: OutAndBack
    node: NodeId | None
    rest: Target | None = None
    parent: NodeId
    stage: Stage = "draw"
    roomy: bool = False
    frontier_m: float = 0.0
    purpose: Purpose | None = None

    @property
    def motion(self) -> Trajectory:
        """What is driven."""
        return self.way.out


class SrtRobot:
    """What the procedures of Multi-SRT work on: one robot's knowledge and place.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    shape : {"ball", "star", "radial"}
        Shape of its local safe regions.
    options : MultiSrtOptions
        The parameters.

    Attributes
    ----------
    map : ExplorationMap
        What it knows of the world, of its own and from others (paper: T and all T_i).
    ways : Ways
        How its body gets from node to node, and to a new place.
    q_act : Configuration
        Where it is.
    here : NodeId or None
        The node that it stands at; None where there is none yet.
    tree : NodeId or None
        Root of the tree that it extends; None while it has nothing to do.
    target : Target or None
        What it is on its way to, over several steps.
    bodies : dict of int to Sighting
        Robots that stand where they were seen and do not answer.
    avoided : dict of int to Sighting
        Robots that stood in its way for so long that it plans around them.
    track : Track or None
        The way off the roadmap that it has found last.
    tried : dict of NodeId to float
        Trees that it has supported, with the open frontier that it could do nothing about.
    considered : tuple of NodeId
        The trees that it has found last to need support.
    stops : float
        Protective stops of late; every motion that reached its end counts against half of one.
    """

    def __init__(self, me: RobotSelf, shape: Shape, options: MultiSrtOptions) -> None:
        self.me = me
        self.shape = shape
        self.options = options
        width = me.footprint.width_m
        self.d_min_m = width if options.d_min_m is None else options.d_min_m
        self.body = PlanningBody(me.footprint, options.margin_m)
        self.planner = SrtPlanner(self.body, me.kinematics, options, self.d_min_m)
        self.map = ExplorationMap(
            reach_m=me.longest_range_m,
            shortest_arc_m=width,
            gaps_count=options.gaps_count,
            robot=me.robot,
        )
        self.ways = Ways(me, self.body, self.map)
        self.root = NodeId(me.robot, 0)
        self.q_act = me.start
        self.time_s = me.time_s
        self.here: NodeId | None = None
        self.tree: NodeId | None = self.root
        self.target: Target | None = None
        self.came: Step | None = None
        self.purpose: Purpose = "explore"
        self.completing = False
        self.exhausted: set[NodeId] = set()
        self.bodies: dict[int, Sighting] = {}
        self.avoided: dict[int, Sighting] = {}
        self.track: Track | None = None
        self.tried: dict[NodeId, float] = {}
        self.considered: tuple[NodeId, ...] = ()
        self._chosen: tuple[tuple[int, int], NodeId] | None = None
        self.boxed_in = 0
        self.stops = 0.0
        self._serial = 0
        self._closings = 0
        self._views: Counter[tuple[int, int]] = Counter()
        self._told_complete = False
        self.team = Team(self)

    @property
    def is_unlimited(self) -> bool:
        """Whether its radio reaches everywhere (paper: unlimited communication range)."""
        return math.isinf(self.me.radio.range_m)

    @property
    def is_boxed_in(self) -> bool:
        """Whether it has found no way at all, time after time."""
        return self.boxed_in > MOST_TRIES

    @property
    def is_car(self) -> bool:
        """Whether it drives as a car does."""
        return isinstance(self.me.kinematics, Car)

    @property
    def can_reverse(self) -> bool:
        """Whether it can drive its way backwards."""
        return self.ways.can_reverse

    # Knowledge ---------------------------------------------------------------------------

    def add(self, region: LocalSafeRegion) -> Steps:
        """ADD: a node to the tree, its region to the map, its place to the roadmap."""
        came = self.came
        node = Node(
            id=NodeId(self.me.robot, self._serial),
            configuration=self.q_act,
            region=region,
            parent=None if came is None else came.parent,
            time_s=self.time_s,
        )
        self._serial += 1
        self.map.add(node)
        self.here = node.id
        self.ways.add(node, None if came is None else came.way, came is not None and came.roomy)
        yield Note(node.added("root" if came is None else came.stage))
        yield from self.tell_when_complete()

    def add_passing(self, region: LocalSafeRegion, step: Step, driven: Trajectory) -> Steps:
        """Add a node where the robot looks round on its way to a new place, and goes on."""
        node = Node(
            id=NodeId(self.me.robot, self._serial),
            configuration=self.q_act,
            region=region,
            parent=step.parent,
            time_s=self.time_s,
        )
        self._serial += 1
        self.map.add(node)
        back = driven.reversed() if self.is_car and self.can_reverse else None
        self.ways.add(node, OutAndBack(driven, back), step.roomy)
        yield Note(node.added("passed"))

    def close(self, node: NodeId, arc: FloatArray, reason: GivenUp) -> Steps:
        """Give up a frontier arc, and remember why."""
        self.map.close(
            Closing(
                id=ClosingId(self.me.robot, self._closings),
                node=node,
                arc=arc,
                reason=reason,
                width_m=self.me.footprint.width_m,
            )
        )
        self._closings += 1
        yield Note(
            ArcClosed(
                time_s=self.time_s,
                robot=self.me.robot,
                node=node,
                reason=reason,
                arc=segments_of(arc),
            )
        )

    def tell_when_complete(self) -> Steps:
        """Put on record that no frontier is left in the map, once."""
        if self._told_complete or (self.here is not None and self.map.has_frontier(self.here)):
            return
        if self.map.is_complete():
            self._told_complete = True
            yield Note(MapComplete(time_s=self.time_s, robot=self.me.robot))

    def may_extend(self, node: NodeId) -> bool:
        """Whether a node's frontier is this robot's concern: that of the tree it is active in."""
        if self.tree is None or not self.map.has_frontier(node):
            return False
        return self.map.tree(node) == self.map.tree(self.tree)

    @property
    def obstacles(self) -> dict[int, Sighting]:
        """Bodies to plan around: those that do not answer, and those that did not give way."""
        return {**self.bodies, **self.avoided}

    def avoid_who_stands(self) -> None:
        """Plan around the robots near by that stand idle, as if they did not answer."""
        for number, _ in self.team.key:
            state = self.team.states.get(number)
            if state is not None and state.phase == "idle":
                self.avoid(number)

    def avoid(self, number: int) -> None:
        """Plan around a robot until the next step is made, or until it goes."""
        self.avoided[number] = Sighting(
            robot=number,
            configuration=Configuration(*self.team.states[number].place),
            footprint=self.team.footprint(number),
        )

    # Other bodies ------------------------------------------------------------------------

    def blocking(self, motion: Trajectory) -> int | None:
        """Give a robot that does not answer and stands in the way of a motion, if there is one."""
        bodies = self.obstacles
        if not bodies:
            return None
        sweep = Sweep(self.me.footprint, motion)
        standing = Sweep(self.me.footprint, standing_at(self.q_act))
        for number, sighting in bodies.items():
            body = Sweep(sighting.footprint, standing_at(sighting.configuration))
            if sweep.distance_to(body) < least_gap(
                standing.distance_to(body), self.options.guard_m
            ):
                return number
        return None

    def is_passable(self, a: NodeId, b: NodeId) -> bool:
        """Whether no robot that does not answer stands on the way between two nodes."""
        if not self.bodies and not self.avoided:
            return True
        (ax, ay, _), (bx, by, _) = self.map[a].configuration, self.map[b].configuration
        if a == self.here:
            return self.goes_straight(bx, by)
        return bool(keep_off(np.array([[ax, ay, bx, by]]), self.berths)[0])

    @property
    def berths(self) -> FloatArray:
        """The bodies to plan around: of each x, y and how far off a way has to be, ``(n, 3)``."""
        own = self.body.outer_radius_m + BEYOND_GUARD * self.options.guard_m
        rows = [
            (*sighting.configuration[:2], own + sighting.footprint.circumscribed_radius_m)
            for sighting in self.obstacles.values()
        ]
        return np.array(rows).reshape(-1, 3)

    def goes_straight(self, x: float, y: float) -> bool:
        """Whether no such body stands in the way straight to a place."""
        heading = self.q_act.heading
        line = Waypoint(0.0, *self.q_act), Waypoint(1.0, x, y, heading)
        return self.blocking(Trajectory(line)) is None

    def refuse(self, x: float, y: float) -> str | None:
        """Say why the robot cannot go straight to a candidate; None if it can."""
        assert self.here is not None
        if not self.obstacles and not self.is_car:
            return None
        way = self.ways.to_place(self.q_act, self.map[self.here].region.boundary, x, y)
        if way is None:
            return "no way for the car" if self.is_car else "no room"
        return None if self.blocking(way.out) is None else "blocked by a robot"

    def notice(self, seen: tuple[Sighting, ...]) -> None:
        """Compare what is seen all around with what is believed of robots that stand."""
        in_sight = {sighting.robot: sighting for sighting in seen}
        region = None if self.here is None else self.map[self.here].region
        for standing in (self.bodies, self.avoided):
            for number, sighting in list(standing.items()):
                x, y, _ = place = sighting.configuration
                if number in in_sight:
                    is_gone = place.distance(in_sight[number].configuration) > SAME_PLACE_M
                else:
                    is_gone = region is not None and inside(region.boundary, x, y)
                if is_gone:
                    del standing[number]
        for sighting in seen:
            self.heed(sighting)

    def heed(self, sighting: Sighting) -> None:
        """Plan around a robot that is seen, if it does not answer or is not stepped with."""
        number = sighting.robot
        if number in self.team.lost or number not in self.team.states:
            self.bodies[number] = sighting
        elif self.team.is_out(number):
            self.avoided[number] = sighting

    # Ways --------------------------------------------------------------------------------

    def past_here(self, target: Target) -> Target | None:
        """Take all nodes on a way at this very place as reached; None if that is all of it.

        Nobody could tell a motion of no length from standing, and let the robot go.
        """
        while len(target.way) > 1:
            a, b = target.way[:2]
            is_here = self.map[b].configuration[:2] == self.q_act[:2]
            if not is_here or len(self.ways.hop(self.q_act, a, b).waypoints) > 1:
                return target
            self.here = b
            target = replace(target, way=target.way[1:])
        return None if isinstance(target, KnownNode) else target

    def step_to(self, target: Target, frontier_m: float = 0.0) -> Step:
        """Give the next motion towards a target."""
        a = target.way[0]
        if len(target.way) > 1:
            b = target.way[1]
            is_last = isinstance(target, KnownNode) and len(target.way) == 2
            return Step(
                way=OutAndBack(self.ways.hop(self.q_act, a, b)),
                node=b,
                rest=None if is_last else replace(target, way=target.way[1:]),
                parent=a,
                frontier_m=frontier_m,
            )
        assert isinstance(target, NewPlace)
        boundary = self.map[a].region.boundary
        way = self.ways.to_place(self.q_act, boundary, target.x, target.y, target.roomy)
        if way is None:
            raise AssertionError(f"no way to ({target.x}, {target.y}), which was found free")
        return Step(
            way=way,
            node=None,
            parent=a,
            stage=target.stage,
            roomy=target.roomy,
            frontier_m=frontier_m,
        )

    def step_by(self, order: Order, planned: Step | None) -> Step | None:
        """Give the step that a master ordered; None: wait."""
        here = self.here
        if order.order == "keep":
            return planned
        if order.order == "wait" or here is None:
            return None
        if order.node is not None:
            if not self.ways.knows_hop(here, order.node):
                return None
            return Step(
                way=OutAndBack(self.ways.hop(self.q_act, here, order.node)),
                node=order.node,
                parent=here,
                purpose="give way",
            )
        # A detour: from the new place on to where the robot was going.
        target = self.target
        rest = None
        if order.order == "new target" and target is not None:
            rest = target if len(target.way) == 1 else replace(target, way=target.way[1:])
        return Step(
            way=OutAndBack(motion_of(order.path)),
            node=None,
            rest=rest,
            parent=here,
            stage="coordinate",
            purpose="give way" if order.order == "give way" else None,
        )

    def resume(self) -> None:
        """From a new node on a detour, go on to the old target if it can be gone to straight."""
        target, here = self.target, self.here
        if target is None or here is None or target.way[0] == here:
            return
        self.target = None
        node = self.map[here]
        seen = [n.region.boundary for n in (node, *self._parent(node))]
        if isinstance(target, NewPlace) and len(target.way) == 1:
            # Where there is something new to be seen, it is planned for that.
            if self.map.has_frontier(here) or self.is_car:
                return
            if any(self._goes_straight(around, target.x, target.y) for around in seen):
                self.target = replace(target, way=(here,), roomy=True)
            return
        self.ways.extend()
        following = target.way[0]
        if following not in self.ways.roadmap.neighbours(here) and not self.is_car:
            x, y, _ = self.map[following].configuration
            if any(self._goes_straight(around, x, y) for around in seen):
                self.ways.join(here, following)
        if following in self.ways.roadmap.neighbours(here):
            self.target = replace(target, way=(here, *target.way))

    def _parent(self, node: Node) -> list[Node]:
        return [] if node.parent is None else [self.map[node.parent]]

    def _goes_straight(self, boundary: FloatArray, x: float, y: float) -> bool:
        # In a region of whichever node, in any heading.
        return self.body.disc_travel(boundary, self.q_act.x, self.q_act.y, x, y)

    def way(self, start: NodeId, end: NodeId) -> list[NodeId] | None:
        """Find the shortest way between two nodes that no robot blocks."""
        if start.robot != self.me.robot or end.robot != self.me.robot:
            self.ways.extend()
        return self.ways.way(start, end, self.is_passable)

    def bypass(self, wanted: Callable[[NodeId], bool]) -> Target | None:
        """Find a way that leads on to the nearest wanted node where the roadmap has none."""
        leg = first_leg(self, wanted)
        if leg is None:
            return None
        start, end = leg
        if not isinstance(end, NodeId):
            return self._off_roadmap(start, end)
        assert self.here is not None
        self.ways.join(start, end)
        way = self.ways.to_nearest(self.here, wanted, self.is_passable)
        return None if way is None else KnownNode(tuple(way))

    def bypass_to(self, x: float, y: float, aim: NodeId) -> NewPlace | None:
        """Find a way that leads on to a place where the roadmap has none."""
        leg = first_leg(self, goal=(x, y))
        if leg is None or isinstance(leg[1], NodeId):
            return None
        place = self._off_roadmap(*leg)
        if place is None:
            return None
        stage: Stage = "complete" if (place.x, place.y) == (x, y) else "bypass"
        return replace(place, stage=stage, aim=aim)

    def _off_roadmap(self, start: NodeId, place: tuple[float, float]) -> NewPlace | None:
        assert self.here is not None
        way = self.way(self.here, start)
        return None if way is None else NewPlace(*place, "bypass", tuple(way), roomy=True)

    def way_length_m(self, way: list[NodeId]) -> float:
        """Length of a way over the roadmap."""
        places = [self.map[node].configuration for node in way]
        return math.fsum(a.distance(b) for a, b in itertools.pairwise(places))

    def way_to_nearest_open(self, start: NodeId) -> list[NodeId] | None:
        """Find the way to the nearest node with a frontier in the tree that is extended."""
        return self.ways.to_nearest(start, self.may_extend, self.is_passable)

    def viewing_place(self, here: NodeId, node: NodeId, arc: FloatArray) -> NewPlace | GivenUp:
        """Stage 3 for one arc: a place from which it can be seen, or why there is none."""
        x, y, *_ = arc_points(arc, self.d_min_m)[0]
        spot = round(x / self.d_min_m), round(y / self.d_min_m)
        if self._views[spot] >= self.options.max_views:
            return "seen from near"
        found = self._view(arc, x, y)
        if isinstance(found, str) and self.obstacles:
            found = self._view(arc, x, y, past_bodies=True)
        if isinstance(found, str):
            return found
        place, start = found
        way = self.way(here, start)
        last = np.array([[*self.map[start].configuration[:2], place.x, place.y]])
        # Who has to wait here may choose it again: it was not looked at meanwhile.
        again = self._chosen == (spot, here)
        self._chosen = spot, here
        if way is not None and keep_off(last, self.berths)[0]:
            self._views[spot] += not again
            return NewPlace(place.x, place.y, "complete", tuple(way), place.roomy, node)
        target = self.bypass_to(place.x, place.y, node)
        if target is None:
            return "blocked by a robot" if self.ways.way(here, start) else "not reachable"
        self._views[spot] += target.stage == "complete" and not again
        return target

    def _view(
        self, arc: FloatArray, x: float, y: float, *, past_bodies: bool = False
    ) -> tuple[Way, NodeId] | Refusal:
        # A place from which an arc around x, y can be seen, and the node from which it is reached.
        refusal: Refusal = "too narrow"
        for window in self._windows():
            near = self.map.near(x, y, math.sqrt(2.0) * window)
            if window < self.me.range_m and not self.planner.may_find_way(x, y, window, near):
                continue
            found = self.planner.viewing_place(
                arc,
                self.map.known_space(x, y, window),
                min(window, self.me.range_m),
                near,
                self._leads(near, self.map.local_union(x, y, window)) if self.is_car else None,
                self.berths if self.obstacles else None,
                past_bodies=past_bodies,
            )
            # A wider window than the robot sees holds no more places, only more ways.
            if not isinstance(found, str):
                return found, near[found.node].id
            refusal = found
            if refusal != "not reachable" and window >= self.me.range_m:
                break
        return refusal

    def _leads(self, near: list[Node], known: BaseGeometry) -> Callable[[int, float, float], bool]:
        return lambda k, x, y: self.ways.leads(near[k], known, x, y)

    def _windows(self) -> list[float]:
        # How far around an arc to look for a place: close by first, which is cheap and mostly
        # enough; at last so far that there is room for the way to a place at the range's end.
        widest = 1.5 * self.me.range_m + self.body.outer_radius_m
        windows = [CLOSE_BY * self.body.outer_radius_m]
        while windows[-1] < widest:
            windows.append(2.0 * windows[-1])
        return [min(window, widest) for window in windows]


def segments_of(segments: FloatArray) -> tuple[Segment, ...]:
    """Write segments as events hold them."""
    return tuple((x0, y0, x1, y1) for x0, y0, x1, y1 in segments.tolist())
