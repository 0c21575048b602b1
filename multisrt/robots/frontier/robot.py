"""One robot that bids for frontiers: what it knows, where it is, and what it can reach."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import cast

import numpy as np
from scipy import ndimage

from multisrt.events import MapComplete
from multisrt.geometry.bodies.clearance import disc_clearance, keep_off
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.euclidean_field import EuclideanField
from multisrt.geometry.grids.grid_path import shortest_path
from multisrt.geometry.grids.occupancy import FrontierGroup, Occupancy
from multisrt.geometry.numerics.distances import inside, nearest_points
from multisrt.geometry.numerics.kernel import FloatArray, IntArray
from multisrt.geometry.regions.safe_region import LocalSafeRegion, local_safe_region
from multisrt.geometry.regions.scan import Scan
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Car
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.robots.explorer import Action, Look, Note, Outcome, RobotSelf, Sense, Sighting
from multisrt.robots.frontier.car_driving import CarDriver
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.team import Team
from multisrt.robots.knowledge import Entries, Entry, Node, NodeId
from multisrt.robots.protective_stop import least_gap

Steps = Generator[Action, Outcome, None]
Watch = Callable[["FrontierRobot"], Steps]

NEAR_BY_CELLS = 8
"""A robot that stands where its raster has no passable cell begins at one so near."""

CORNER_CELLS = 0.25
"""Ways are planned so much farther from walls, in cells, for the corners that they cut."""

ROUNDING_M = 1e-9
"""By so much less a robot is as far off as it was."""

MOVED_M = 0.05
"""A robot that was seen elsewhere by more than this has moved."""

MOST_JAMS = 100
"""So often a robot and others cannot let each other pass, at one place and with nothing new known;
then it is jammed."""

MOST_FIELDS = 8
"""Distance fields that a robot keeps, so as not to begin them anew."""

NOTHING_AROUND: FloatArray = np.empty((0, 3))
"""Discs that a robot's ways lead around, where no bodies are in its way."""


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """Where a robot goes.

    Attributes
    ----------
    x, y : float
        The place, a cell's centre.
    path : (n, 2) array
        The way there from where the robot was when it chose.
    cost_m : float
        Length of that way.
    """

    x: float
    y: float
    path: FloatArray
    cost_m: float

    @property
    def place(self) -> tuple[float, float]:
        """The place as a pair."""
        return self.x, self.y


@dataclass(frozen=True, slots=True)
class BodyInTheWay:
    """A robot that stands in another's way and does not leave.

    Attributes
    ----------
    sighting : Sighting
        Where it was seen.
    until_s : float
        Until when it is taken for an obstacle; inf: it does not answer, and is one until it is
        heard of or seen elsewhere.
    """

    sighting: Sighting
    until_s: float

    @property
    def is_lost(self) -> bool:
        """Whether it is taken as lost."""
        return math.isinf(self.until_s)


class FrontierRobot:
    """What the rules of frontier bidding work on: one robot's knowledge and place.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    options : FrontierOptions
        The parameters.
    watch : callable, optional
        Done whenever something new was seen.

    Attributes
    ----------
    raster : Occupancy
        What it knows of the world, of its own and from others.
    at : Configuration
        Where it stands, or stood before the motion that goes on.
    region : LocalSafeRegion
        What it saw last, from where it stood then.
    goal : Goal or None
        Where it goes.
    detour : Goal or None
        The same place by another way, where another robot bars the first one.
    team : Team
        What it knows of the others.
    bodies : dict of int to BodyInTheWay
        Robots that stand in its way and do not leave.
    jammed_by : dict of int to int
        How often which robots and it could not let each other pass, where it stands.
    car : CarDriver or None
        What plans its ways, if it is a car.
    """

    def __init__(self, me: RobotSelf, options: FrontierOptions, watch: Watch | None = None) -> None:
        self.me = me
        self.watch = watch
        self.options = options
        widest = me.footprint.width_m
        if options.cell_m > widest:
            raise InvalidInputError(
                f"cell_m is {options.cell_m:g}: cells are wider than the body of robot "
                f"{me.robot}; choose at most {widest:g}"
            )
        # Ways between cells run nearer to walls than the cells' centres lie: the body is driven
        # with less of a margin than its ways are planned with.
        self.body = PlanningBody(me.footprint, 0.5 * options.margin_m)
        self._disc = PlanningBody(Footprint.disc(self.body.outer_radius_m), 0.5 * options.margin_m)
        self.raster = Occupancy(
            options.cell_m,
            self.body.outer_radius_m + options.margin_m + CORNER_CELLS * options.cell_m,
        )
        self.entries = Entries()
        self.at = me.start
        self.time_s = me.time_s
        self.here: NodeId | None = None
        self.region: LocalSafeRegion | None = None
        self.goal: Goal | None = None
        self.motion: Trajectory | None = None
        self.set_out_s = 0.0
        self.bodies: dict[int, BodyInTheWay] = {}
        self._around = NOTHING_AROUND
        self.told_complete = False
        self.chosen_s = -math.inf
        self.chosen_at = -1
        self.detour: Goal | None = None
        self.waits = 0
        self._waited_at = 0
        self.detoured_at: tuple[float, float] | None = None
        self.jammed_by: dict[int, int] = {}
        self._jammed_at: tuple[tuple[float, float], int] | None = None
        self._stuck_at: tuple[float, float] | None = None
        self._serial = 0
        self._given_up: dict[tuple[float, float], None] = {}
        self._no_way: dict[tuple[float, float], int] = {}
        self._out_of_reach: dict[int, FrontierGroup] = {}
        self._instead: dict[int, tuple[FrontierGroup, tuple[float, float]]] = {}
        self._seen_in_vain: dict[tuple[float, float], None] = {}
        self._fields: dict[tuple[int, int], tuple[int, DistanceField]] = {}
        self.team = Team(self)
        drive = me.kinematics
        self.car = CarDriver(self, drive) if isinstance(drive, Car) else None

    @property
    def boundary(self) -> FloatArray:
        """The border of what the robot saw last."""
        assert self.region is not None
        return self.region.boundary

    def begin(self) -> Steps:
        """Look round for the first time, and ask what the others know."""
        yield from self.perceive()
        if not self.team.is_alone:
            yield from self.team.report(asks=True)
            yield from self.team.pause(self.team.round_trip_s)

    def set_goal(self, goal: Goal | None) -> None:
        """Take a goal, chosen by what is known now."""
        self.goal = goal
        self.chosen_s = self.time_s
        self.chosen_at = self.raster.revision

    def may_choose_anew(self) -> bool:
        """Whether the map has changed since the goal was chosen, and that is long enough ago."""
        return (
            self.options.replan == "news"
            and self.raster.revision != self.chosen_at
            and self.time_s >= self.chosen_s + self.options.replan_period_s
        )

    def sees_at_half_range(self, goal: Goal) -> bool:
        """Whether a goal lies within half the range and in sight, where that is enough.

        It is not for a goal of which more can be seen only from near by.
        """
        if self.options.reached == "cell" or goal.place in self._seen_in_vain:
            return False
        near = math.dist(self.at[:2], goal.place) <= 0.5 * self.me.range_m
        return near and inside(self.boundary, goal.x, goal.y)

    # Knowledge ---------------------------------------------------------------------------

    def perceive(self, maps: bool = True) -> Steps:
        """Look round; what is new becomes a node, and is told.

        Without `maps` the robot looks only where it can drive, and forgets it again.
        """
        scan = cast(Scan, (yield Sense()))
        self.time_s = scan.time_s
        region = local_safe_region(scan, self.options.shape, cones=self.options.cones)
        self.region = region
        if not maps:
            return
        before = self.raster.revision
        self.raster.add(region)
        # Also that a free cell is occupied is news: else others would still go there to see.
        if self.raster.revision == before and self.here is not None:
            return
        node = Node(
            id=NodeId(self.me.robot, self._serial),
            configuration=scan.configuration,
            region=region,
            parent=self.here,
            time_s=self.time_s,
        )
        self._serial += 1
        self.entries.add_node(node)
        self.here = node.id
        yield Note(node.added("root" if node.parent is None else "scan"))
        if not self.team.is_alone:
            yield from self.team.report()
        if self.watch is not None:
            yield from self.watch(self)

    def merge(self, entries: tuple[Entry, ...]) -> tuple[NodeId, ...]:
        """Take in what others saw; give what was new."""
        new = []
        for entry in entries:
            if isinstance(entry, Node) and self.entries.add_node(entry):
                self.raster.add(entry.region)
                new.append(entry.id)
        return tuple(new)

    def groups(self) -> list[FrontierGroup]:
        """Give the groups of frontier cells that are wide enough to be worth going to."""
        least = self.options.least_frontier_m
        return self.raster.frontier_groups(self.me.footprint.width_m if least is None else least)

    def targets(self) -> FloatArray:
        """Give the places to go to, ``(m, 2)``: one for each group where the body can stand.

        Groups are left out to which no way was found, until they change; see `look_closer`.
        """
        groups = [g for g in self.groups() if id(g) not in self._out_of_reach]
        if not self._instead and not self._given_up:
            # Mostly they are where the raster has them: all at once.
            return self.raster.centres_of([g.target for g in groups if g.target is not None])
        places = [self._target(group) for group in groups]
        return np.array([place for place in places if place is not None]).reshape(-1, 2)

    def look_closer(self, field: DistanceField) -> bool:
        """Find other targets for groups whose own one cannot be reached; tell if that changes any.

        The cells of a group need not all be joined by ways: it may begin behind a gap too narrow
        for the body and end in the open.
        """
        found = False
        known, self._out_of_reach, instead = self._out_of_reach, {}, {}
        for group in self.groups():
            place = self._target(group)
            if place is None:
                continue
            if id(group) in self._instead:
                instead[id(group)] = self._instead[id(group)]
            if np.isfinite(field.distance(self.indices_of(np.array([place])))[0]):
                found |= id(group) in known
                continue
            cells = self._left_of(group)
            costs = field.distance(self.indices_of(cells)) if len(cells) else np.empty(0)
            cells = cells[np.isfinite(costs)]
            if len(cells):
                x, y = _nearest_to_middle(self.raster.centres_of(group.cells), cells)
                instead[id(group)] = group, (x, y)
                found = True
            elif not self.bodies:
                self._out_of_reach[id(group)] = group
        self._instead = instead
        return found

    def _target(self, group: FrontierGroup) -> tuple[float, float] | None:
        if group.target is None:
            return None
        place = self.raster.centre_of(*group.target)
        if id(group) in self._instead:
            place = self._instead[id(group)][1]
        if not self._given_up:
            return place
        # From where it was given up nothing is seen of it: perhaps from another of its cells.
        left = self._left_of(group)
        if not len(left):
            return None
        if any(place == (x, y) for x, y in left.tolist()):
            return place
        return _nearest_to_middle(self.raster.centres_of(group.cells), left)

    def _left_of(self, group: FrontierGroup) -> FloatArray:
        # The centres of a group's passable cells that are not near a place given up.
        centres = self.raster.centres_of(group.cells)
        left = centres[self.raster.passable[self.raster.indices_of(group.cells)]]
        if not self._given_up or not len(left):
            return left
        apart = nearest_points(np.array(list(self._given_up)), left)
        far: FloatArray = left[apart > 0.5 * self.me.footprint.width_m]
        return far

    def judge(self, goal: Goal, reason: str) -> None:
        """Give a goal up that was reached in vain, or to which no way led twice from one place."""
        self.note_progress()
        if reason == "reached" and self.is_frontier(*goal.place):
            if math.dist(self.at[:2], goal.place) < 0.5 * self.me.footprint.width_m:
                self.give_up(goal.place)
            self._seen_in_vain[goal.place] = None
        elif reason == "no way":
            if self.car is not None:
                self._no_way[goal.place] = self.raster.revision
            if self._stuck_at == self.at[:2]:
                self.give_up(goal.place)
            self._stuck_at = self.at[:2]

    def note_progress(self) -> None:
        """Begin to count anew how often the robot waits, if it has learned anything since."""
        if self.raster.revision != self._waited_at:
            self.waits, self._waited_at = 0, self.raster.revision

    def note_jam(self, other: int) -> None:
        """Count that another robot did not let this one pass, or could not be let pass."""
        if not self._stands_as_jammed():
            self.jammed_by, self._jammed_at = {}, (self.at[:2], self.raster.revision)
        self.jammed_by[other] = self.jammed_by.get(other, 0) + 1

    @property
    def is_jammed(self) -> bool:
        """Whether that was so too often here: neither asking nor giving way leads any further."""
        return self._stands_as_jammed() and sum(self.jammed_by.values()) >= MOST_JAMS

    def _stands_as_jammed(self) -> bool:
        if self._jammed_at is None:
            return False
        place, known = self._jammed_at
        return known == self.raster.revision and math.dist(place, self.at[:2]) <= MOVED_M

    def give_up(self, place: tuple[float, float]) -> None:
        """Make no place a goal again from which nothing new is seen, or to which no way leads."""
        self._given_up[place] = None

    def try_again(self) -> bool:
        """Let a car try places anew that it gave up for want of a way; tell if there are any.

        Whether one leads there depends on where a car stands, and how, and on what room it knows
        to turn round: so when nothing else is left, and it has learned anything since.
        """
        again = [p for p, known in self._no_way.items() if known != self.raster.revision]
        for place in again:
            del self._no_way[place]
            self._given_up.pop(place, None)
        return len(again) > 0

    def is_frontier(self, x: float, y: float) -> bool:
        """Whether there is still something to be seen around a place."""
        return self.raster.has_frontier_near(x, y, 0.5 * self.me.footprint.width_m)

    def tell_when_complete(self) -> Steps:
        """Put on record that no frontier is left in the map, once."""
        if not self.told_complete:
            self.told_complete = True
            yield Note(MapComplete(time_s=self.time_s, robot=self.me.robot))

    def driven_body(self) -> PlanningBody:
        """Give the body that legs are planned for: a disc around it, which turns anywhere.

        Through a gap that only its narrow side fits through it could get, but not turn there if
        something new is seen or heard. Only where the disc has no room, as at a start perhaps,
        it drives as it is.
        """
        if self.body.is_disc:
            return self.body
        x, y, _ = self.at
        has_room = disc_clearance(self.boundary, x, y) >= self.body.outer_radius_m
        return self._disc if has_room else self.body

    # Ways ---------------------------------------------------------------------------------

    def field(self, x: float, y: float) -> DistanceField | None:
        """Give the distances from a place over what is known to be passable.

        Fields are kept, and repaired where the map has changed since. None where no cell near
        the place is passable.
        """
        raster = self.raster
        cell = raster.passable_near(x, y, NEAR_BY_CELLS)
        if cell is None:
            return None
        known = self._fields.pop(cell, None)
        if known is not None and known[1].passable is raster.passable:
            revision, field = known
            changed = raster.changed_since(revision)
            if changed is not None:
                field.repair(raster.window_of(changed))
        else:
            field = self._new_field(raster.centre_of(*cell))
        self._fields[cell] = raster.revision, field
        if len(self._fields) > MOST_FIELDS:
            self._fields.pop(next(iter(self._fields)))
        return field

    def own_field(self) -> DistanceField | None:
        """Give the distances from where the robot stands; call within `around_bodies`."""
        x, y, _ = self.at
        cell = self.first_cell()
        if cell is None:
            return None
        # From the very place, so that the path does not begin with a turn to a cell's centre.
        here = cell == self.raster.cell_of(x, y)
        return self._new_field((x, y) if here else self.raster.centre_of(*cell))

    def first_cell(self) -> tuple[int, int] | None:
        """Give the cell at which its ways begin; call within `around_bodies`.

        It is the nearest passable cell. Beside a body that may be one from which no way leads, or
        one to which the robot gets only past the body; then it is the nearest from which a way
        leads and to which it gets straight. None: there is no such cell.
        """
        raster, (x, y, _) = self.raster, self.at
        nearest = raster.passable_near(x, y, NEAR_BY_CELLS)
        if nearest is None or nearest == raster.cell_of(x, y):
            return nearest
        around = raster.passable_centres(x, y, (NEAR_BY_CELLS - 0.5) * raster.cell_m)
        cells = raster.cells_of(around)
        corner = cells.min(axis=0)
        window = np.zeros(cells.max(axis=0) - corner + 1, np.bool_)
        window[tuple((cells - corner).T)] = True
        labels = ndimage.label(window)[0]
        rim = np.abs(cells - raster.cell_of(x, y)).max(axis=1) >= NEAR_BY_CELLS
        own = labels[tuple((cells - corner).T)]
        leads = np.isin(own, own[rim])
        keeps_off = self._keeps_off_bodies(raster.centre_of(*nearest))
        if keeps_off and leads[(cells == nearest).all(axis=1)].any():
            return nearest
        away = np.hypot(*(around - (x, y)).T)
        for k in np.flatnonzero(leads)[np.argsort(away[leads], kind="stable")].tolist():
            place_x, place_y = around[k].tolist()
            if self._keeps_off_bodies((place_x, place_y)) and self.body.disc_travel(
                self.boundary, x, y, place_x, place_y
            ):
                row, column = cells[k].tolist()
                return row, column
        return nearest if keeps_off else None

    def _keeps_off_bodies(self, place: tuple[float, float]) -> bool:
        # Whether no body that ways lead around would stop the robot on the straight way there.
        x, y, _ = self.at
        guard_m, berths = self.options.guard_m, self._around.copy()
        for berth in berths:
            apart, radii = math.dist(berth[:2], (x, y)), berth[2]
            gap = min(guard_m, least_gap(max(0.0, apart - radii), guard_m))
            berth[2] = min(apart - ROUNDING_M, radii + gap)
        return bool(keep_off(np.array([[x, y, *place]]), berths)[0])

    def _new_field(self, source: tuple[float, float]) -> DistanceField:
        raster = self.raster
        return DistanceField(raster.passable, raster.cell_m, [source], x0=raster.x0, y0=raster.y0)

    def indices_of(self, places: FloatArray) -> IntArray:
        """Give where the cells of places are in the raster's arrays, ``(k, 2)``."""
        return np.column_stack(self.raster.indices_of(self.raster.cells_of(places)))

    def goal_at(self, field: DistanceField, x: float, y: float) -> Goal:
        """Give a place as a goal, with the way there."""
        index = self.indices_of(np.array([[x, y]]))[0]
        if self.options.paths == "eedt":
            raster = self.raster
            path = EuclideanField(
                raster.passable, raster.cell_m, field.sources[0], x0=raster.x0, y0=raster.y0
            ).path(index)
        else:
            path = shortest_path(field, index)
        whole = np.vstack([[self.at[:2]], path])
        return Goal(x, y, whole, length_of(whole))

    # Other bodies --------------------------------------------------------------------------

    def look(self) -> Generator[Action, Outcome, tuple[Sighting, ...]]:
        """Notice who stands around; forget those who are not where they were seen."""
        seen = cast(tuple[Sighting, ...], (yield Look()))
        places = {sighting.robot: sighting for sighting in seen}
        for number, body in list(self.bodies.items()):
            if number in places:
                has_left = has_moved(places[number], body.sighting)
            else:
                x, y, _ = body.sighting.configuration
                has_left = inside(self.boundary, x, y)
            if has_left or self.time_s >= body.until_s:
                del self.bodies[number]
        return seen

    @contextmanager
    def around_bodies(self, sightings: Iterable[Sighting] = ()) -> Iterator[None]:
        """Take the cells that bodies keep this one from for not passable, meanwhile.

        Ways begin then where none of these bodies stops the robot.
        """
        own = self.body.outer_radius_m
        standing = (body.sighting for body in self.bodies.values())
        bodies = {s.robot: s for s in (*standing, *sightings)}
        discs = NOTHING_AROUND
        if bodies:
            discs = np.array(
                [
                    (*s.configuration[:2], own + s.footprint.circumscribed_radius_m)
                    for s in bodies.values()
                ]
            )
        before, self._around = self._around, discs
        try:
            with self.raster.blocked(discs + np.array([0.0, 0.0, self.options.guard_m])):
                yield
        finally:
            self._around = before

    def goal_around(self, goal: Goal, sightings: Iterable[Sighting], limit_m: float) -> Goal | None:
        """Give a goal with a way around bodies, if there is one that is not too long."""
        with self.around_bodies(sightings):
            field = self.own_field()
            index = self.indices_of(np.array([goal.place]))
            if field is None or not field.distance(index)[0] <= limit_m:
                return None
            around = self.goal_at(field, goal.x, goal.y)
        return around if around.cost_m <= limit_m else None

    def blocked_frontiers(self) -> bool:
        """Whether there are frontiers to which only other bodies bar the way."""
        if not self.bodies:
            return False
        field = self.own_field()
        if field is None:
            return False
        self.look_closer(field)
        targets = self.targets()
        return len(targets) > 0 and field.first(self.indices_of(targets)) is not None

    def only_lost_bodies(self) -> bool:
        """Whether all bodies in the way are of robots that do not answer."""
        return all(body.is_lost for body in self.bodies.values())

    def now_at(self) -> Configuration:
        """Where the robot is at this moment, also while it drives."""
        if self.motion is None:
            return self.at
        return self.motion.at(self.time_s - self.set_out_s)


def length_of(path: FloatArray) -> float:
    """Give the length of a polyline ``(n, 2)``."""
    steps = np.diff(path, axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())


def _nearest_to_middle(group: FloatArray, places: FloatArray) -> tuple[float, float]:
    away = np.hypot(*(places - group.mean(axis=0)).T)
    x, y = places[int(np.argmin(away))].tolist()
    return x, y


def has_moved(now: Sighting, then: Sighting) -> bool:
    """Whether a robot is not where it was."""
    return now.configuration.distance(then.configuration) > MOVED_M
