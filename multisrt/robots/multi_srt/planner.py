"""PLANNER: the next target of a robot, by its three stages.

Source: Multi-SRT, paper section 2, "Planner"; differs in: the paper has the first stage, *draw*,
and the return to the parent. The stages *approach* and *complete* are needed for an exploration
to finish; the recording says which of them found a target. With ``choice="gain"`` all this gives
way to the choice of an arc by its value, see `best_arc`.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Literal

from multisrt.events import Choice, ClosingReason
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.srt import Draws
from multisrt.robots.explorer import Action, Outcome, Sighting, Steps
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.best_arc import best_arc
from multisrt.robots.multi_srt.progress import BoxedIn, Event
from multisrt.robots.multi_srt.robot import SrtRobot
from multisrt.robots.multi_srt.targets import Barred, KnownNode, NewPlace, Target

Found = tuple[Choice, Target | None]
"""What a planner chose, and the target. Without a target the choice says what the robot does: `end`
or `stay`. All other choices only say, for the record, how the target was found."""

Choosing = Generator[Action, Outcome, Found]

TargetChooser = Callable[[FloatArray, Draws], Choosing]
"""Chooses the next target for the local frontier ``(m, 4)``; draws are counted in the second."""


class Planner:
    """PLANNER for one tree: from its first node to its completion.

    Parameters
    ----------
    robot : SrtRobot
        The robot that extends the tree.
    completing : bool
        Whether the third stage is reached already, as in the tree of another robot. Before, a
        robot without a target goes back to the parent of its node, as in the paper. The stage
        begins at the root, or where no path leads back to the parent, as when a body blocks it;
        from then on the robot goes over the roadmap, and does so until the tree is complete.
    """

    def __init__(self, robot: SrtRobot, *, completing: bool = False) -> None:
        self._robot = robot
        self._completing = completing
        self._postponed: set[tuple[NodeId, bytes]] = set()
        self._postponed_with = 0

    def __call__(self, frontier: FloatArray, draws: Draws) -> Choosing:
        """Choose the next target from the current node.

        Parameters
        ----------
        frontier : (m, 4) array
            The local frontier.
        draws : Draws
            Filled with the number of candidates drawn, and with those refused.

        Returns
        -------
        choice : Choice
            How the target was found; `end` if there is nothing left to do, `stay` if there is no
            path to get anywhere.
        target : Target or None
            The target; None with `end` and `stay`.

        Raises
        ------
        BoxedIn
            If walls beside its start leave the robot no motion.
        """
        robot = self._robot
        here = robot.at.node
        if robot.homing is not None:
            robot.homing.has_left_out = False
        if robot.options.choice == "gain":
            best = yield from best_arc(robot, self._arcs_to_go_to, self._postpone, draws)
            if best is None:
                return (yield from self._complete(here))
            return ("bypass" if best[0] else "gain"), best[1]
        found = self._draw_or_approach(here, frontier, draws)
        if found is not None:
            return found
        is_free = not robot.obstacles and not self._has_left_out
        if robot.options.no_place_after is not None and len(frontier) and is_free:
            yield from robot.team.tell_no_place(here)
        parent = robot.map[here].parent
        steps_back = robot.options.backtrack == "parent" and not self._completing
        if steps_back and parent is not None and here != robot.at.tree:
            route = robot.routes.route(here, parent)
            if route is not None:
                if robot.homing is not None and self._is_late(here):
                    robot.homing.raise_out_of_time()
                return "parent", KnownNode(tuple(route))
        return (yield from self._complete(here))

    @property
    def _has_left_out(self) -> bool:
        # Whether this choice has left a target out, as the robot has no time for it.
        return self._robot.homing is not None and self._robot.homing.has_left_out

    def _is_late(self, here: NodeId) -> bool:
        # Whether there is a node with frontier, and no time for any.
        return self._robot.routes.to_nearest(here, self._may_go_to) is None and self._has_left_out

    def _may_go_to(self, node: NodeId) -> bool:
        # Whether a node has frontier that no body bars, and the robot time to go there.
        robot = self._robot
        if not robot.trees.may_extend(node):
            return False
        if robot.homing is None:
            return True
        route = robot.routes.route(robot.at.node, node)
        return route is None or not robot.homing.leaves_out(KnownNode(tuple(route), node))

    def _draw_or_approach(self, here: NodeId, frontier: FloatArray, draws: Draws) -> Found | None:
        robot, node = self._robot, self._robot.map[here]
        options, sensing_m = robot.options, robot.me.range_m
        biased = options.frontier_bias
        if biased and not len(frontier):
            return None
        x, y, _ = node.configuration
        reach_m = max(sensing_m, node.region.range_m)  # that of another robot, at its nodes
        others = robot.map.places_near(x, y, reach_m + robot.planner.d_min_m)
        near = [] if biased else robot.map.near(x, y, 2.0 * sensing_m)
        place, drawn = robot.planner.draw(
            robot.at.q_act,
            node.region,
            frontier,
            others,
            [other.region for other in near if other.id != here],
            robot.me.rng,
            accept=robot.refuse,
        )
        draws.drawn, draws.refused, draws.candidates = (
            drawn.drawn,
            drawn.refused,
            drawn.candidates,
        )
        if place is not None:
            return "draw", NewPlace(*place, "draw", (here,))
        if not options.approach or not len(frontier):
            return None
        place = robot.planner.approach(
            robot.at.q_act,
            node.region,
            robot.deferred.arcs(here),
            others,
            accept=robot.refuse,
            draws=draws,
        )
        return None if place is None else ("approach", NewPlace(*place, "approach", (here,)))

    def _complete(self, here: NodeId) -> Choosing:
        # Over the roadmap: to a node with a frontier, or to a place that sees one; at last home.
        robot = self._robot
        tree, drawn_out = robot.at.tree, robot.views.drawn_out
        assert tree is not None
        drawn_out.add(here)
        robot.roadmap.extend()
        supports = tree != robot.trees.root
        if robot.options.backtrack == "nearest_open" or (supports and not robot.options.complete):
            route = robot.routes.to_nearest(
                here,
                lambda n: (
                    n not in drawn_out and not robot.is_without_place(n) and self._may_go_to(n)
                ),
            )
            if route is not None:
                return "nearest_open", KnownNode(tuple(route), route[-1])
        if robot.options.complete:
            self._completing = True
            found = yield from self._view_or_close(here, tree)
            if found is not None:
                return found
            yield from robot.trees.tell_when_complete()
        if here == tree or supports:
            return "end", None
        return on_the_way(robot, tree, "home")

    def _view_or_close(
        self, here: NodeId, tree: NodeId
    ) -> Generator[Action, Outcome, Found | None]:
        # A target that leads to a view of an arc; arcs of which there is no view are closed. One to
        # whose views no path leads is postponed until nothing else is left: nodes that are added
        # meanwhile may be what is missing.
        robot = self._robot
        trees, routes = robot.trees, robot.routes
        late: set[NodeId] = set()

        def may_go_to(node: NodeId) -> bool:
            return node not in late and self._may_go_to(node) and bool(self._arcs(node))

        while (route := routes.to_nearest(here, may_go_to)) is not None:
            node = route[-1]
            for arc in self._arcs(node):
                found = robot.views.viewing_place(node, arc)
                if isinstance(found, NewPlace) and robot.leaves_out(found):
                    late.add(node)
                    break
                if isinstance(found, NewPlace):
                    return ("bypass" if found.is_interim else "complete"), found
                if node not in robot.views.drawn_out:
                    # A node of another robot, at which this one has drawn no candidate yet.
                    return "nearest_open", KnownNode(tuple(route), node)
                if isinstance(found, Barred):
                    yield from trees.defer(node, arc, found.bodies)
                elif found == "not reachable":
                    self._postpone(node, arc)
                else:
                    yield from self._close(node, arc, found)
        past_bodies = robot.bypass.to(may_go_to)
        if past_bodies is not None:
            return "bypass", past_bodies
        if robot.homing is not None and robot.homing.has_left_out:
            robot.homing.raise_out_of_time()
        if self._take_up_postponed():
            return (yield from self._view_or_close(here, tree))
        return (yield from self._close_the_rest(here, tree))

    def _close_the_rest(
        self, here: NodeId, tree: NodeId
    ) -> Generator[Action, Outcome, Found | None]:
        # Close the arcs to whose views no path leads, or return one off the roadmap.
        robot = self._robot
        for node in robot.map.open_nodes(tree):
            bodies = self._bodies_before(here, node)
            for arc in robot.deferred.arcs(node):
                if bodies and not self._is_postponed(node, arc):
                    yield from robot.trees.defer(node, arc, bodies)
                    continue
                place = robot.views.off_the_roadmap(node, arc)
                if place is None and robot.may_be_barred_in:
                    return "stay", None
                if place is None:
                    yield from self._close(node, arc, "not reachable")
                    continue
                if robot.homing is not None and robot.leaves_out(place):
                    robot.homing.raise_out_of_time()
                return ("bypass" if place.is_interim else "complete"), place
        return None

    def _arcs_to_go_to(self, node: NodeId) -> list[FloatArray]:
        return self._arcs(node) if self._may_go_to(node) else []

    def _arcs(self, node: NodeId) -> list[FloatArray]:
        # The arcs of a node that no body bars and that are not postponed.
        arcs = self._robot.deferred.arcs(node)
        return [arc for arc in arcs if not self._is_postponed(node, arc)]

    def _is_postponed(self, node: NodeId, arc: FloatArray) -> bool:
        # An arc that has been cut since is another one.
        return (node, arc.tobytes()) in self._postponed

    def _postpone(self, node: NodeId, arc: FloatArray) -> None:
        if not self._postponed:
            self._postponed_with = len(self._robot.map.nodes)
        self._postponed.add((node, arc.tobytes()))

    def _take_up_postponed(self) -> bool:
        # Whether arcs were postponed when fewer nodes were known: they are looked at again.
        if not self._postponed or len(self._robot.map.nodes) == self._postponed_with:
            return False
        self._postponed.clear()
        return True

    def _close(self, node: NodeId, arc: FloatArray, reason: ClosingReason) -> Steps:
        # A robot that walls leave no motion cannot tell what can be reached, nor a car that finds
        # none from its start.
        if reason == "not reachable" and self._robot.roadmap.is_car:
            self._robot.finds_no_motion = True
        if self._robot.is_walled_in:
            self._robot.lacks_room = True
            self._robot.progress.note(Event.NO_ROOM)
            raise BoxedIn
        yield from self._robot.trees.close(node, arc, reason)

    def _bodies_before(self, here: NodeId, node: NodeId) -> dict[int, Sighting]:
        # The bodies that block the path to a node, by robot; none if none would lead there anyway.
        robot = self._robot
        route = robot.roadmap.path(here, node)
        if route is not None:
            return robot.routes.bodies_on(route)
        return robot.obstacles.all if robot.bypass.leads_without_bodies(node.__eq__) else {}


def on_the_way(robot: SrtRobot, end: NodeId, choice: Literal["home", "transfer"]) -> Found:
    """Choose a node as the target: over the roadmap, or past bodies off it; or stay for now."""
    route = robot.routes.route(robot.at.node, end)
    if route is not None:
        return choice, KnownNode(tuple(route))
    past_bodies = robot.bypass.to(lambda node: node == end)
    return ("stay", None) if past_bodies is None else ("bypass", past_bodies)
