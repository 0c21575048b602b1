"""A base class for explorers that only choose the next place in a map of local safe regions."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Literal, NoReturn

import numpy as np

from multisrt.events import ArcClosed, ClosingReason
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.robots.defects import ExplorerDefect
from multisrt.robots.exploration_map import ExplorationMap
from multisrt.robots.explorer import Note, RobotSelf, Steps
from multisrt.robots.frontier.driving import Driven, drive
from multisrt.robots.frontier.explore import FrontierExplorer
from multisrt.robots.frontier.goal import Goal, Place
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.progress import Event
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.wavefront_rules import Choice
from multisrt.robots.knowledge import Closing, ClosingId
from multisrt.robots.toolkit.decisions import decided
from multisrt.robots.toolkit.places import places_of

BESIDE_CELLS = 2
"""Maximum distance, in cells beyond the radius of the body, from a chosen place to the place
where the body can stand that replaces it."""


class RegionOptions(FrontierOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of a `RegionExplorer`: those of `FrontierOptions`, with other defaults.

    Attributes
    ----------
    sense : {"targets", "moving"}
        As above; by default only scans at the chosen places become part of the map.
    replan : {"target", "news"}
        As above; by default a place is chosen when the previous one is reached.
    """

    sense: Literal["moving", "targets"] = "targets"
    replan: Literal["news", "target"] = "target"


@dataclass(frozen=True, slots=True, kw_only=True)
class Teammate:
    """The last reported state of another robot.

    Attributes
    ----------
    robot : int
        Its number.
    place : Configuration
        Its place at the time of its last report.
    goal : (x, y) or None
        Its goal.
    """

    robot: int
    place: Configuration
    goal: Place | None


class RegionExplorer(ABC):
    """Explores by driving to places that `choose` selects in a map of local safe regions.

    Derive a class that implements `choose`. Sensing, driving around obstacles, sending and merging
    nodes, and giving way are those of the frontier family.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows about itself.
    options : RegionOptions
        The parameters.

    Attributes
    ----------
    me, options
        The arguments.
    map : ExplorationMap
        Its own nodes and those of others, each with its local safe region and remaining frontier.
        Read-only.

    Examples
    --------
    >>> class Newest(RegionExplorer):
    ...     '''To the middle of a frontier of the newest node that has one.'''
    ...
    ...     def choose(self):
    ...         for node in reversed(self.map.open_nodes()):
    ...             for arc in self.map.frontier_arcs(node):
    ...                 place = arc[len(arc) // 2, :2]
    ...                 if np.isfinite(self.costs(place)[0]):
    ...                     return place
    ...         return None
    >>> import multisrt as ms
    >>> from multisrt.robots.registry import registered
    >>> with registered(ms.Strategy.of(Newest)):
    ...     run = ms.explore("open", strategy="newest", seed=1)
    >>> run.metrics.coverage > 0.95
    True
    """

    def __init__(self, me: RobotSelf, options: RegionOptions) -> None:
        if not isinstance(me, RobotSelf):
            raise InvalidInputError(
                f"a run builds {type(self).__name__} for each of its robots: give the class, and "
                "not one that is built already"
            )
        self.me = me
        self.options = options
        self.map = ExplorationMap(
            reach_m=me.max_range_m, min_arc_m=me.footprint.width_m, robot=me.robot
        )
        self._explorer = FrontierExplorer(
            me, options, self._choose, self._drive, barred=lambda _: self._is_barred
        )
        # Whether bodies alone bar the paths to a place that was asked for in the last choice.
        self._is_barred = False
        # Whether the raster, too, had frontier at the place when it was chosen.
        self._is_frontier = False
        self._closings = 0
        self._explanation: tuple[str, Any, dict[str, Any]] | None = None

    @abstractmethod
    def choose(self) -> Any:
        """Return the place to scan from next.

        Returns
        -------
        place or None
            A place in any form accepted by `places_of`. The robot goes to the nearest place where
            its body can stand. The place must be reachable: `costs` is finite there. None if there
            is no place left: the robot is done until it receives new data.
        """

    # Information for `choose` ---------------------------------------------------------------

    @property
    def at(self) -> Configuration:
        """The present configuration of the robot."""
        return self._robot.at

    @property
    def time_s(self) -> float:
        """The present time in seconds."""
        return self._robot.time_s

    def teammates(self) -> list[Teammate]:
        """Return the last reported states of the other robots, by number.

        Returns
        -------
        list of Teammate
            The reports, without robots that have nothing to do or have not been heard from for
            `options.lost_after_s`.
        """
        return [
            Teammate(robot=report.robot, place=Configuration(*report.place), goal=report.goal)
            for report in self._robot.team.present()
        ]

    def costs(self, places: Any) -> FloatArray:
        """Return the lengths of the robot's shortest paths to places.

        Parameters
        ----------
        places : (m, 2) array_like, or a single place
            See `places_of`. Each is replaced by the nearest place where the body can stand, if
            there is one close by.

        Returns
        -------
        (m,) array
            Lengths in metres; ``inf`` if there is no path, if other robots block all paths, if
            there is no time to go there and then home (option `home`), and for places where the
            robot has scanned or that it failed to reach.
        """
        wanted = places_of(places)
        with self._robot.around_bodies():
            found = self._path_lengths(wanted)
        if len(self._robot.bodies) and not np.isfinite(found).all():
            free = np.isfinite(self._path_lengths(wanted))
            self._is_barred |= bool((free & ~np.isfinite(found)).any())
        return found

    def explain(self, text: str, options: Any = (), **values: Any) -> None:
        """Record a reason for the next choice; to be called in `choose`.

        Parameters
        ----------
        text : str
            The reason.
        options : (m, 2) array_like or sequence of places
            The places that were considered.
        **values : (m,) array_like
            The criteria; see `decided`.
        """
        self._explanation = text, options, values

    # Execution ------------------------------------------------------------------------------

    def run(self) -> Steps:
        """Yield actions, as required by `multisrt.robots.explorer.Explorer`."""
        yield from self._explorer.run()

    @property
    def _robot(self) -> FrontierRobot:
        return self._explorer.robot

    def _choose(self, robot: FrontierRobot, because: Event) -> Choice:
        if robot.goal is not None:
            yield from self._leave_behind(robot.goal.place, because)
        self._merge()
        self._explanation, self._is_barred = None, False
        chosen = self.choose()
        goal = None if chosen is None else self._goal_at(chosen)
        nothing: dict[str, Any] = {}
        text, options, values = self._explanation or (
            "no place is left" if chosen is None else "it was chosen",
            (),
            nothing,
        )
        self._is_frontier = goal is not None and robot.is_frontier(*goal.place)
        # On record is the place as it was chosen, which is one of the options.
        place = None if goal is None else chosen
        yield decided(self.me, robot.time_s, text, place, options, **values)
        return goal

    def _drive(self, robot: FrontierRobot, goal: Goal) -> Driven:
        # The raster's frontier may be gone where arcs of regions are left: a drive that ended for
        # that at once would be chosen again, and again.
        return drive(robot, goal, all_the_way=not self._is_frontier)

    def _leave_behind(self, place: Place, because: Event) -> Steps:
        # There is no second time at a place that was chosen, for any robot: others would go there
        # in vain, and meet in its corner.
        robot = self._robot
        if because is Event.REACHED:
            robot.frontiers.give_up(place)
            yield from self._close_near(place, "seen from near")
        elif because is Event.NO_WAY and robot.frontiers.is_given_up(place):
            if math.dist(robot.at[:2], place) <= self._near_m:
                # The last of the path is too narrow; from here it sees as much.
                yield from robot.perceive()
                yield from self._close_near(place, "seen from near")
            elif robot.car is None and not len(robot.bodies):
                yield from self._close_near(place, "not reachable")

    def _merge(self) -> None:
        entries = self._robot.map.entries
        self.map.merge((*entries.nodes.values(), *entries.closings.values()))

    @property
    def _near_m(self) -> float:
        # As far as the places may lie that are taken as one, diagonally.
        return math.sqrt(2.0) * (self._beside_cells + 1) * self._robot.raster.cell_m

    def _close_near(self, place: Place, reason: ClosingReason) -> Steps:
        # Give up what is still frontier next to a place, for all robots.
        self._merge()
        near_m = self._near_m
        for node in self.map.near(*place, self.me.max_range_m + near_m):
            arc = within_disc(self.map.frontier(node.id), place, near_m)
            if not len(arc):
                continue
            closing = Closing(
                id=ClosingId(self.me.robot, self._closings),
                node=node.id,
                arc=arc,
                reason=reason,
                width_m=self.me.footprint.width_m,
            )
            self._closings += 1
            self.map.close(closing)
            self._robot.map.entries.add_closing(closing)
            yield Note(
                ArcClosed(
                    time_s=self.time_s,
                    robot=self.me.robot,
                    node=node.id,
                    reason=reason,
                    arc=tuple((x0, y0, x1, y1) for x0, y0, x1, y1 in arc.tolist()),
                )
            )

    def _goal_at(self, chosen: Any) -> Goal | None:
        robot = self._robot
        places = places_of(chosen, "what choose returned")
        if len(places) != 1:
            self._refuse(f"choose returned {len(places)} places", "return one, or None")
        [(x, y)] = places.tolist()
        standing = self._standing_near(x, y)
        if standing is None or robot.frontiers.is_given_up(standing):
            why = "where its body cannot stand" if standing is None else "which it has tried before"
            self._refuse(
                f"choose returned ({x:g}, {y:g}), {why}",
                "return a place to which self.costs is finite, or None",
            )
        with robot.around_bodies():
            field = robot.own_field()
            if field is not None and self._leads(field, standing):
                return robot.goal_at(field, *standing)
        free = robot.field(*robot.at[:2])
        if free is None or not self._leads(free, standing):
            self._refuse(
                f"choose returned ({x:g}, {y:g}), to which no path leads",
                "return a place to which self.costs is finite, or None",
            )
        # Other robots stand in the way: it waits for them.
        self._is_barred = True
        return None

    def _path_lengths(self, wanted: FloatArray) -> FloatArray:
        found = np.full(len(wanted), np.inf)
        field = self._robot.own_field()
        if field is None:
            return found
        standing = [self._standing_near(x, y) for x, y in wanted.tolist()]
        usable = [
            k
            for k, place in enumerate(standing)
            if place is not None and not self._robot.frontiers.is_given_up(place)
        ]
        if usable:
            places = np.array([standing[k] for k in usable])
            found[usable] = self._robot.fitting_costs(field, places)
        return found

    def _leads(self, field: DistanceField, place: Place) -> bool:
        return bool(np.isfinite(field.distance(self._robot.indices_of(np.array([place])))[0]))

    def _standing_near(self, x: float, y: float) -> Place | None:
        raster = self._robot.raster
        cell = raster.passable_near(x, y, self._beside_cells)
        return None if cell is None else raster.centre_of(*cell)

    @property
    def _beside_cells(self) -> int:
        robot = self._robot
        return math.ceil(robot.body.outer_radius_m / robot.raster.cell_m) + BESIDE_CELLS

    def _refuse(self, what: str, remedy: str) -> NoReturn:
        raise ExplorerDefect(
            what, f"{type(self).__name__} of robot {self.me.robot} at {self.time_s:g} s", remedy
        )


def within_disc(segments: FloatArray, centre: Place, radius_m: float) -> FloatArray:
    """Return the parts of segments that lie in a disc.

    Parameters
    ----------
    segments : (n, 4) array
        x0, y0, x1, y1 of each in metres.
    centre : (x, y)
        Centre of the disc in metres.
    radius_m : float
        Its radius in metres.

    Returns
    -------
    (k, 4) array
        The parts of positive length.

    Examples
    --------
    >>> segments = np.array([[-3.0, 0.0, 1.0, 0.0], [0.0, 3.0, 1.0, 3.0]])
    >>> within_disc(segments, (0.0, 0.0), 2.0).tolist()
    [[-2.0, 0.0, 1.0, 0.0]]
    """
    start = segments[:, :2] - np.array(centre)
    along = segments[:, 2:] - segments[:, :2]
    # |start + t along|^2 = radius^2 is a t^2 + 2 b t + c = 0.
    a, b = (along**2).sum(axis=1), (start * along).sum(axis=1)
    c = (start**2).sum(axis=1) - radius_m**2
    meets = (a > 0.0) & (b**2 > a * c)
    a, b, c, start, along = a[meets], b[meets], c[meets], start[meets], along[meets]
    root = np.sqrt(b**2 - a * c)
    first, last = np.maximum(0.0, (-b - root) / a), np.minimum(1.0, (root - b) / a)
    begin = segments[meets, :2]
    parts = np.hstack([begin + first[:, None] * along, begin + last[:, None] * along])
    inside: FloatArray = parts[first < last]
    return inside
