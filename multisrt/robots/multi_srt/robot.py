"""One Multi-SRT robot: the parts that the procedures of the paper work on."""

from __future__ import annotations

import math

from multisrt.geometry.regions.shapes import Shape
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.srt import SrtPlanner
from multisrt.robots.exploration_map import ExplorationMap
from multisrt.robots.explorer import RobotSelf, Sighting
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.bypass import Bypass
from multisrt.robots.multi_srt.deferred_arcs import DeferredArcs
from multisrt.robots.multi_srt.homing import SrtHoming
from multisrt.robots.multi_srt.journey import Journey
from multisrt.robots.multi_srt.obstacles import Obstacles
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.multi_srt.progress import Progress
from multisrt.robots.multi_srt.roadmap import SrtRoadmap
from multisrt.robots.multi_srt.roster import Roster
from multisrt.robots.multi_srt.routes import Routes
from multisrt.robots.multi_srt.targets import NewPlace, Target
from multisrt.robots.multi_srt.team import Team
from multisrt.robots.multi_srt.trees import Trees
from multisrt.robots.multi_srt.views import Views
from multisrt.robots.multi_srt.whereabouts import Whereabouts


class SrtRobot:
    """One robot's knowledge and current task.

    The parts know one another only as far as their parameters say, and none knows the robot.

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
    planner : SrtPlanner
        Chooses places in the current region.
    at : Whereabouts
        Where the robot is, at what time, and which tree it extends.
    map : ExplorationMap
        All nodes that it knows, its own and those of others.
    trees : Trees
        What it adds to the map, and which frontier is left (paper: T and all T_i).
    roadmap : SrtRoadmap
        How its body gets from node to node, and to a new place.
    obstacles : Obstacles
        Bodies of others that it plans around.
    deferred : DeferredArcs
        The frontier that is left to it, without the arcs to which bodies block the path.
    routes, bypass : Routes, Bypass
        Routes over the roadmap that keep off them, and where there is none, paths off the roadmap.
    views : Views
        Places from which frontier arcs are seen.
    journey : Journey
        Its target, and the steps that lead there.
    team : Team
        What it tells and is told; `team.roster` is what it knows of the others.
    progress : Progress
        Whether it makes progress, and what it does where it does not.
    homing : SrtHoming or None
        When it delivers its data, if it ever does.
    finds_no_motion : bool
        Whether it is a car that found no motion to a place from which an arc is seen.
    lacks_room : bool
        Whether it gave up at its start, where walls alone leave it no motion.

    Raises
    ------
    InvalidInputError
        If the time limit is too short to deliver data.
    """

    def __init__(self, me: RobotSelf, shape: Shape, options: MultiSrtOptions) -> None:
        width_m = me.footprint.width_m
        body = PlanningBody(me.footprint, options.margin_m)
        d_min_m = options.distance_from_nodes_m(width_m)
        self.me = me
        self.shape = shape
        self.options = options
        self.planner = SrtPlanner(body, me.kinematics, options, d_min_m)
        self.map = ExplorationMap(
            reach_m=me.max_range_m,
            min_arc_m=width_m,
            gaps_count=options.gaps_count,
            robot=me.robot,
        )
        self.at = Whereabouts(q_act=me.start, time_s=me.time_s)
        self.roadmap = SrtRoadmap(me, body, self.map)
        self.obstacles = Obstacles(body, options.guard_m)
        roster = Roster(me, options, self.at, self.obstacles)
        self.deferred = DeferredArcs(self.map, roster, options.max_reopenings)
        self.trees = Trees(me, self.at, self.map, self.roadmap, self.deferred)
        self.at.tree = self.trees.root
        self.routes = Routes(self.at, self.map, self.roadmap, self.obstacles)
        self.bypass = Bypass(me, body, self.routes)
        self.views = Views(me, self.planner, self.bypass, options.max_views)
        self.journey = Journey(self.at, self.map, self.roadmap)
        self.progress = Progress(options)
        self.finds_no_motion = False
        self.lacks_room = False
        self.team = Team(me, options, self.at, self.map, roster)
        self.homing = (
            None
            if options.home == "never" or me.base is None
            else SrtHoming(me, options, self.at, self.map, self.routes, self.team)
        )

    @property
    def has_unlimited_range(self) -> bool:
        """Whether distance does not limit its radio (paper: unlimited communication range)."""
        return math.isinf(self.me.radio.range_m)

    @property
    def is_walled_in(self) -> bool:
        """Whether the robot has never left its start, where its region has no room to turn.

        Or, if it is a car, where it has found no motion to what it sees.
        """
        if self.has_left:
            return False
        if self.finds_no_motion:
            return True
        node = self.map[self.trees.root]
        return not self.planner.body.is_roomy(node.region.boundary, node.configuration)

    @property
    def may_be_barred_in(self) -> bool:
        """Whether it is a car at its start, and bodies may be why it finds no motion from there."""
        return self.roadmap.is_car and bool(self.obstacles) and not self.has_left

    @property
    def has_left(self) -> bool:
        """Whether the robot has left its start, or added a node there."""
        root = self.trees.root
        return self.at.here != root or NodeId(self.me.robot, root.serial + 1) in self.map

    def is_without_place(self, node: NodeId) -> bool:
        """Whether robots like this one found no place at a node `no_place_after` times."""
        limit = self.options.no_place_after
        return limit is not None and self.team.without_place[node] >= limit

    def leaves_out(self, target: Target) -> bool:
        """Return whether there is no time for a target and the path home; see `SrtHoming`."""
        return self.homing is not None and self.homing.leaves_out(target)

    def refuse(self, x: float, y: float) -> str | None:
        """Return why the robot cannot go straight to a candidate; None if it can."""
        at = self.at
        if self.leaves_out(NewPlace(x, y, "draw", (at.node,))):
            return "no time"
        if not self.obstacles and not self.roadmap.is_car:
            return None
        out_and_back = self.roadmap.to_place(at.q_act, self.map[at.node].region.boundary, x, y)
        if out_and_back is None:
            return "no way for the car" if self.roadmap.is_car else "no room"
        blocking = self.obstacles.blocking(at.q_act, out_and_back.out)
        return None if blocking is None else "blocked by a robot"

    def notice(self, seen: tuple[Sighting, ...]) -> None:
        """Take in which bodies are in sight: forget those that are gone, plan around the rest."""
        here = self.at.here
        view = None if here is None else self.map[here].region.boundary
        self.obstacles.forget_gone(seen, view)
        self.deferred.notice(seen, view)
        for sighting in seen:
            self.heed(sighting)

    def heed(self, sighting: Sighting) -> None:
        """Plan around a robot that is seen, if it does not answer or is left out of the groups."""
        roster = self.team.roster
        if not roster.answers(sighting.robot):
            self.obstacles.silent[sighting.robot] = sighting
        elif roster.is_out(sighting.robot):
            self.obstacles.avoided[sighting.robot] = sighting

    def avoid(self, number: int) -> None:
        """Plan around a robot of the group until the next step is made, or until it goes."""
        self.obstacles.avoided[number] = self.team.roster.sighting(number)

    def avoid_idle_robots(self) -> None:
        """Plan around the robots of the group that stand idle, as if they did not answer."""
        states = self.team.roster.states
        for number in self.team.companions:
            if number in states and states[number].phase == "idle":
                self.avoid(number)
