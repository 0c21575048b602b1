"""The SRT explorer: BUILD_SRT of the Multi-SRT paper, for one robot."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Generator
from dataclasses import dataclass
from typing import Literal, cast

from multisrt.events import ArcClosed, Decision, MapComplete, NodeAdded, Segment, Stage
from multisrt.exploration_map import ExplorationMap, Node, NodeId
from multisrt.explorer import Action, Done, Move, Moved, Note, Outcome, RobotSelf, Sense
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.frontier_arcs import total_length
from multisrt.geometry.kernel import FloatArray
from multisrt.geometry.safe_region import LocalSafeRegion, Shape, local_safe_region
from multisrt.geometry.scan import Scan
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Holonomic, turns_between
from multisrt.planners.motion.roadmap import Roadmap
from multisrt.planners.motion.steering import steer, turn_and_drive
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.planners.srt import CLOSE_BY, Draws, Refusal, SrtOptions, SrtPlanner, Way, arc_points

Steps = Generator[Action, Outcome, None]


@dataclass(frozen=True, slots=True)
class NewPlace:
    """The planner's target is a place without a node.

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
    """

    x: float
    y: float
    stage: Stage
    way: tuple[NodeId, ...]
    roomy: bool = False


@dataclass(frozen=True, slots=True)
class KnownNode:
    """The planner's target is a node of the tree, at the end of a way over the roadmap."""

    way: tuple[NodeId, ...]


Target = NewPlace | KnownNode


class SrtExplorer:
    """Explores by a Sensor-based Random Tree of balls, stars or radial regions.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    shape : {"ball", "star", "radial"}
        Shape of its local safe regions.
    options : SrtOptions
        Parameters of the planner.
    """

    def __init__(self, me: RobotSelf, shape: Shape, options: SrtOptions) -> None:
        self.me = me
        self.shape = shape
        self.options = options
        width = me.footprint.width_m
        self.d_min_m = width if options.d_min_m is None else options.d_min_m
        self.body = PlanningBody(me.footprint, options.margin_m)
        self.planner = SrtPlanner(self.body, me.kinematics, options, self.d_min_m)
        self.map = ExplorationMap(
            reach_m=me.range_m, shortest_arc_m=width, gaps_count=options.gaps_count
        )
        self.roadmap: Roadmap[NodeId] = Roadmap()
        self.q_act = me.start
        self.time_s = 0.0
        self._bridged = 0
        self._roomy: set[frozenset[NodeId]] = set()
        self._views: Counter[tuple[int, int]] = Counter()
        self._turns: dict[NodeId, float] = {}
        self._has_room: set[NodeId] = set()
        self._exhausted: set[NodeId] = set()
        self._completing = False
        self._told_complete = False

    def run(self) -> Steps:
        """Explore until nothing is left to do, and go home."""
        yield from self.build_srt()
        open_nodes = self.map.open_nodes()
        frontier = [self.map.frontier(node) for node in open_nodes]
        length = self.map.open_frontier_m()
        yield Done(
            complete=not open_nodes,
            reason="every frontier arc is explored or closed"
            if not open_nodes
            else f"the planner has no target, with {length:.1f} m of frontier left open "
            f"at {len(open_nodes)} nodes",
            frontier=tuple(segment for arcs in frontier for segment in _segments(arcs)),
        )

    def build_srt(self) -> Steps:
        """BUILD_SRT (paper 003, Figure 2), each turn: perceive, add, plan, move."""
        parent: NodeId | None = None
        stage: Stage = "root"
        roomy = False
        while True:
            scan = yield Sense()
            region = local_safe_region(
                cast(Scan, scan),
                self.shape,
                cones=self.options.cones,
                contact_tolerance_m=self.options.contact_tolerance_m,
            )
            self.time_s = cast(Scan, scan).time_s
            node = Node(
                id=NodeId(self.me.robot, len(self.map)),
                configuration=self.q_act,
                region=region,
                parent=parent,
                time_s=self.time_s,
            )
            yield from self.add(node, stage, roomy)
            here = node.id
            while True:
                target = yield from self.plan(here)
                if target is None:
                    return
                yield from self.move_to(target)
                here = target.way[-1]
                if isinstance(target, NewPlace):
                    break
            parent, stage, roomy = here, target.stage, target.roomy

    def add(self, node: Node, stage: Stage, roomy: bool) -> Steps:
        """ADD: a node to the tree, its region to the map, its place to the roadmap."""
        self.map.add(node)
        self.roadmap.add(node.id)
        if node.parent is not None:
            parent = self.map[node.parent]
            length = parent.configuration.distance(node.configuration)
            self.roadmap.connect(node.parent, node.id, length)
            if roomy:
                self._join_roomy(node.parent, node.id)
        if self.body.has_room(node.region.boundary, node.configuration):
            self._has_room.add(node.id)
        yield Note(
            NodeAdded(
                time_s=self.time_s,
                robot=self.me.robot,
                serial=node.id.serial,
                parent=node.parent,
                configuration=(*node.configuration,),
                stage=stage,
                boundary=tuple(zip(*node.region.boundary.T.tolist(), strict=True)),
                tags=(node.region.tags + ord("0")).tobytes().decode(),
            )
        )
        yield from self._tell_when_complete()

    def plan(self, here: NodeId) -> Generator[Action, Outcome, Target | None]:
        """PLANNER: the next target from a node, by its three stages; None at the end."""
        node = self.map[here]
        x, y, _ = node.configuration
        frontier = self.map.frontier(here)
        place, draws = None, Draws()
        if len(frontier) or not self.options.frontier_bias:
            others = self.map.places_near(x, y, self.me.range_m + self.d_min_m)
            place, draws = self.planner.draw(
                self.q_act, node.region, frontier, others, self._regions_around(here), self.me.rng
            )
        choice: Literal["draw", "approach", "complete", "parent", "nearest_open", "home", "end"]
        target: Target | None
        if place is not None:
            choice, target = "draw", NewPlace(*place, "draw", (here,))
        elif (
            self.options.approach
            and len(frontier)
            and (
                place := self.planner.approach(
                    self.q_act, node.region, self.map.frontier_arcs(here), others
                )
            )
        ):
            choice, target = "approach", NewPlace(*place, "approach", (here,))
        elif (
            node.parent is not None and self.options.backtrack == "parent" and not self._completing
        ):
            choice, target = "parent", KnownNode((here, node.parent))
        else:
            choice, target = yield from self._what_is_left(here)
        yield Note(
            Decision(
                time_s=self.time_s,
                robot=self.me.robot,
                node=here,
                frontier_m=total_length(frontier),
                choice=choice,
                target=self._place_of(target),
                draws=draws.drawn,
                refused=draws.refused,
            )
        )
        return target

    def move_to(self, target: Target) -> Steps:
        """MOVE_TO: hop by hop over the roadmap, then straight to a place without a node."""
        for a, b in zip(target.way, target.way[1:], strict=False):
            yield from self._follow(self._hop(a, b))
        if isinstance(target, NewPlace):
            yield from self._follow(self._first_way(target))

    def _regions_around(self, here: NodeId) -> list[LocalSafeRegion]:
        # Where candidates must not lie, if they are not drawn towards the frontier.
        if self.options.frontier_bias:
            return []
        x, y, _ = self.map[here].configuration
        near = self.map.near(x, y, 2.0 * self.me.range_m)
        return [node.region for node in near if node.id != here]

    def _what_is_left(
        self, here: NodeId
    ) -> Generator[
        Action,
        Outcome,
        tuple[Literal["complete", "nearest_open", "home", "end"], Target | None],
    ]:
        # Over the roadmap: to a node with a frontier, or to a place that opens one; at last home.
        root = NodeId(self.me.robot, 0)
        self._exhausted.add(here)
        if self.options.backtrack == "nearest_open":
            self._extend_roadmap()
            way = self.roadmap.way_to_nearest(
                here, lambda n: n not in self._exhausted and self.map.has_frontier(n)
            )
            if way is not None:
                return "nearest_open", KnownNode(tuple(way))
        if self.options.complete:
            self._completing = True
            self._extend_roadmap()
            while (way := self.roadmap.way_to_nearest(here, self.map.has_frontier)) is not None:
                place = yield from self._complete(here, way[-1])
                if place is not None:
                    return "complete", place
            yield from self._tell_when_complete()
        if here == root:
            return "end", None
        way = self.roadmap.way(here, root)
        if way is None:
            raise AssertionError("the tree joins every node to the root")
        return "home", KnownNode(tuple(way))

    def _complete(self, here: NodeId, node: NodeId) -> Generator[Action, Outcome, NewPlace | None]:
        # Stage 3 for one node: a place from which an arc of it can be seen, or the arc is closed.
        for arc in self.map.frontier_arcs(node):
            x, y, *_ = arc_points(arc, self.d_min_m)[0]
            spot = round(x / self.d_min_m), round(y / self.d_min_m)
            found: Way | Refusal = "seen from near"
            for window in self._windows():
                if self._views[spot] >= self.options.max_views:
                    break
                near = self.map.near(x, y, math.sqrt(2.0) * window)
                found = self.planner.viewing_place(
                    arc,
                    self.map.local_union(x, y, window),
                    min(window, self.me.range_m),
                    near,
                )
                # A wider window than the robot sees holds no more places, only more ways.
                if found != "not reachable" and (
                    not isinstance(found, str) or window >= self.me.range_m
                ):
                    break
            if not isinstance(found, str):
                way = self.roadmap.way(here, near[found.node].id)
                if way is not None:
                    self._views[spot] += 1
                    return NewPlace(found.x, found.y, "complete", tuple(way), found.roomy)
                found = "not reachable"
            self.map.close(node, arc)
            yield Note(
                ArcClosed(
                    time_s=self.time_s,
                    robot=self.me.robot,
                    node=node,
                    reason=found,
                    arc=_segments(arc),
                )
            )
        return None

    def _windows(self) -> list[float]:
        # How far around an arc to look for a place: close by first, which is cheap and mostly
        # enough; at last so far that there is room for the way to a place at the range's end.
        widest = 1.5 * self.me.range_m + self.body.outer_radius_m
        windows = [CLOSE_BY * self.body.outer_radius_m]
        while windows[-1] < widest:
            windows.append(2.0 * windows[-1])
        return [min(window, widest) for window in windows]

    def _first_way(self, target: NewPlace) -> Trajectory:
        # The way to a place without a node; how the body turned for it is remembered.
        if target.roomy or self.body.is_disc:
            return turn_and_drive(self.me.kinematics, self.q_act, target.x, target.y)
        here = self.map[target.way[-1]]
        motion = steer(
            self.body,
            self.me.kinematics,
            here.region.boundary,
            self.q_act,
            target.x,
            target.y,
        )
        if motion is None:
            raise AssertionError(f"no way to ({target.x}, {target.y}), which was found free")
        first, last = motion.waypoints[0], motion.waypoints[-1]
        self._turns[NodeId(self.me.robot, len(self.map))] = last.heading - first.heading
        return motion

    def _hop(self, a: NodeId, b: NodeId) -> Trajectory:
        """Give the way between two nodes that are joined.

        Where there is room, a body turns and drives. In a narrow place a body that is no disc
        retraces the way on which it first came to the child of the two: it stands at a narrow
        node as it first came there, turns as it then turned, and drives; and back in reverse.
        """
        start, end = self.map[a], self.map[b]
        x, y, _ = end.configuration
        drive = self.me.kinematics
        if (
            self.body.is_disc
            or isinstance(drive, Holonomic)
            or frozenset((a, b)) in self._roomy
            or self._is_wide(start, end)
        ):
            return turn_and_drive(drive, self.q_act, x, y)
        child = end if end.parent == a else start
        along = child.configuration.heading
        if a in self._has_room:
            turned = drive.turn(self.q_act, turns_between(self.q_act.heading, along)[0])
        elif child is end:
            turned = drive.turn(self.q_act, self._turns[b])
        else:
            turned = drive.turn(self.q_act, 0.0)
        driven = turned.then(drive.drive(turned.end, x, y))
        if child is start and b not in self._has_room:
            return driven.then(drive.turn(driven.end, -self._turns[a]))
        return driven

    def _is_wide(self, a: Node, b: Node) -> bool:
        # Whether the tree's way between two nodes has room for any heading.
        if a.id not in self._has_room or b.id not in self._has_room:
            return False
        parent, child = (a, b) if b.parent == a.id else (b, a)
        (px, py, _), (cx, cy, _) = parent.configuration, child.configuration
        return self.body.disc_travel(parent.region.boundary, px, py, cx, cy)

    def _follow(self, motion: Trajectory) -> Steps:
        outcome = yield Move(motion)
        moved = cast(Moved, outcome)
        self.q_act, self.time_s = moved.configuration, moved.time_s

    def _extend_roadmap(self) -> None:
        # Bridges: ways straight from node to node that stay in the region of one of them.
        nodes = self.map.nodes
        for node in nodes[self._bridged :]:
            x, y, _ = node.configuration
            for other in self.map.near(x, y, self.me.range_m):
                pair = frozenset((node.id, other.id))
                if other.id >= node.id or pair in self._roomy:
                    continue
                ox, oy, _ = other.configuration
                if self.body.disc_travel(
                    node.region.boundary, x, y, ox, oy
                ) or self.body.disc_travel(other.region.boundary, ox, oy, x, y):
                    self._join_roomy(node.id, other.id)
                    self.roadmap.connect(
                        node.id, other.id, node.configuration.distance(other.configuration)
                    )
        self._bridged = len(nodes)

    def _join_roomy(self, a: NodeId, b: NodeId) -> None:
        self._roomy.add(frozenset((a, b)))
        self._has_room.update((a, b))

    def _tell_when_complete(self) -> Steps:
        if not self._told_complete and self.map.is_complete():
            self._told_complete = True
            yield Note(MapComplete(time_s=self.time_s, robot=self.me.robot))

    def _place_of(self, target: Target | None) -> tuple[float, float] | None:
        if target is None:
            return None
        if isinstance(target, NewPlace):
            return target.x, target.y
        configuration: Configuration = self.map[target.way[-1]].configuration
        return configuration.x, configuration.y


def _segments(segments: FloatArray) -> tuple[Segment, ...]:
    return tuple((x0, y0, x1, y1) for x0, y0, x1, y1 in segments.tolist())
