"""Robots that end left no frontier that they could have reached, whatever reason they give."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Final, cast

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.campaign.invariants.open_frontier import (
    OpenFrontier,
    Reach,
    frontiers,
    open_frontiers,
    solid,
    standing_space,
    stretches,
    united,
    without,
)
from multisrt.campaign.judged_run import ROUNDING_M, JudgedRun
from multisrt.campaign.violations import Violation, quoted
from multisrt.events import (
    ArcClosed,
    Blocked,
    Coordinated,
    Ended,
    Learned,
    Motion,
    NodeAdded,
    NodeName,
    Sent,
)
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.shapes import Shape
from multisrt.robots.naming import BOXED_IN, NO_CHAIN, WALLED_IN
from multisrt.simulation.sensing import measured
from multisrt.spec import RangeFinderSpec

COMPLETE: Final = "complete-is-complete"
BARRED: Final = "boxed-in-is-boxed-in"
CHAIN: Final = "chain-reaches-no-goal"

SHARPEST_RAD: Final = math.radians(45.0)
"""Minimum angle of a corner of an obstacle that may stand unseen between two beams."""

BLIND: Final = 1.5
"""Factor on what a laser leaves out beside a wall, for corners of two walls."""

DEFAULT_VIEWS: Final = 3
"""With fewer views of a spot (`max_views`) an arc may be given up that is not seen at all."""

MIN_BEHIND_M2: Final = 0.05
"""Smaller unknown parts are scraps."""

CELLS_BEYOND: Final = 4.0
"""Cells by which a frontier exceeds the minimum of the rules, so that it is one on any raster."""

SRT_SLACK_M: Final = 0.02
"""A body of the SRT family keeps off walls by this much more than its margin, in metres."""

SRT_LATTICE: Final = 0.09
"""A lattice of viewing places of the SRT family holds one in any disc of this radius; as a share
of `d_min_m`."""

SRT_MIN_EXCESS_M: Final = 0.1
"""A frontier of the SRT family is longer than a body is wide by this, in metres."""

SRT_RASTER: Final = 0.3
"""Room beside a body that its paths off the roadmap certainly find on their raster, as a share of
its circumscribed radius."""

SRT_SCRAP_M: Final = 0.05
"""Unknown parts between its regions that hold no disc of this radius are scraps, in metres."""

SAME_BORDER_M: Final = 1e-4
"""Maximum distance in metres between borders of the SRT family's regions that count as one."""

LEFT_M: Final = 0.01
"""A robot that was farther from its start than this has left it, in metres."""

BODY_SLACK_M: Final = 0.05
"""Added to the distance that robots keep from bodies, in metres."""

IN_THE_WAY: Final = " in the way to "
"""In the reason of a robot of the SRT family that ended with frontier behind other bodies."""

BELIEF_S: Final = 30.0
"""Time for which a robot of the SRT family may not know that a body has left, in seconds."""


def complete_is_complete(run: JudgedRun) -> Violation | None:
    """Check that a robot that reports a complete map left no frontier that it could explore.

    For each robot that is alive and whose last end is complete, the regions of all nodes that it
    knew then (in a complete run: at the end of the run) are united and subtracted from the true
    free space around its start. The remainder is unknown to the robot. Its frontier is the part of
    the border of the unknown area that is visible, in the true map, from a place where its body can
    stand; that place is connected to the place of the robot by known places away from walls. A
    contiguous visible frontier must be no longer than the rules of the strategy may leave:

    - bidding: `min_frontier_m` (the body's width by default), counted in cells, of which a diagonal
      line has fewer by the square root of two; and four cells. The body stands three cells from it,
      because goals are cells at the frontier; paths keep 1.5 cells from the unknown area, and two
      cells and the margin from walls; unknown parts that contain no disc with the radius of a cell
      are ignored;
    - SRT: the body's width and 0.1 m, within the range, or with `srt-ball` within the ball at the
      place. The body keeps its margin and 0.02 m from walls and from the unknown area. Only the
      frontier of the robot's own tree counts, because other trees are left to their robots: the
      border of its regions that no other region covers. Places within `completion_spacing` times
      `d_min_m`, plus a cell of its lattice of places, of a node do not count, nor places to which
      no straight path leads from a node, and none with room of 0.3 times the body's radius beside
      it. Unknown parts that contain no disc of 0.05 m are ignored.

    Arcs that were closed as seen from nearby count only if a scan from the place shows at least
    what the rules count as more, an area of `d_min_m` squared, and at least 0.05 m2: in a corner
    that narrows, stars show only a strip at a time. If `max_views` is less than 3, or `d_min_m`
    greater than the body's width, such arcs do not count at all, because too few views of too large
    an area are allowed. Nor do they with `srt-ball`: a ball hardly wider than the body has no place
    that is not near its node, and its arc is closed before other robots know the space around it.

    Arcs that the robot closed as not reachable do not count if it could not reach them with what it
    knew then: what it learns later does not open them again.

    Also ignored are unknown parts of less than 0.05 m2; with stars and balls, places within
    `contact_tolerance_m` of a wall; with a laser, places so close to a wall that its beams omit
    them. These are not checked: cars, whose turns are not computed here and which give up places to
    which they find no path; robots that go to frontiers with `shape=ball`, which drive within the
    last ball and give up all goals if it is as small as the distance to a wall; SRT with
    `gaps_count=false`, which leaves gaps on purpose; and robots with so few beams that the free
    space that they show is no larger than the body and its distance from walls.

    Cost: a few overlays for each such robot.
    """
    for robot, end in sorted(run.ends.items(), key=lambda item: item[1].time_s):
        if not end.complete or not _may_judge(run, robot):
            continue
        whole = run.recording.footer.outcome == "complete"
        at_s = run.end_s if whole else end.time_s
        found = _left(run, robot, known_at(run, robot, None if whole else end), at_s)
        if found:
            return _violation(COMPLETE, robot, end, found[0])
    return None


def boxed_in_is_boxed_in(run: JudgedRun) -> Violation | None:
    """Check that a robot that reports being boxed in cannot reach a frontier past other bodies.

    As for `complete_is_complete`, with the bodies of all other robots as obstacles: at all places
    where they were during the time for which the robot may have assumed them to be there (1.5 times
    `body_stays_s` for robots that go to frontiers, 30 s for SRT), enlarged by the distance of the
    protective stop and a tolerance of 0.05 m or two cells. A robot of the SRT family that reports
    bodies in the way to some frontier may assume the bodies, too, of the times at which it found
    arcs blocked, because it does not return there to see whether they have left; it is not checked
    if it stands so near to a body that all of its paths begin too near to it. Robots that ended
    because they and others failed too often to let each other pass (`max_jams`; SRT:
    `gives_up_after`) may have a path, and are not checked. Nor are robots that are boxed in at
    their start, which they have not left, where the region of their first scan has less room around
    them than they keep.

    Cost: a few overlays for each such robot.
    """
    for robot, end in sorted(run.ends.items(), key=lambda item: item[1].time_s):
        boxed_in, barred = end.reason.startswith(BOXED_IN), IN_THE_WAY in end.reason
        if end.complete or not (boxed_in or barred) or not _may_judge(run, robot):
            continue
        if _is_jammed(run, robot, end) or _is_walled_in(run, robot, end):
            continue
        belief_s = BELIEF_S if run.family == "srt" else 1.5 * run.options["body_stays_s"]
        if barred and _is_beside_a_body(run, robot, end.time_s):
            continue
        times_s = [*_blocked_s(run, robot), end.time_s] if barred else [end.time_s]
        bodies = bodies_around(run, robot, times_s, belief_s)
        found = _left(run, robot, known_at(run, robot, end), end.time_s, bodies)
        if found:
            return _violation(BARRED, robot, end, found[0])
    return None


def chain_reaches_no_goal(run: JudgedRun) -> Violation | None:
    """Check that a robot whose chain reaches no goal cannot reach one without a chain.

    As for `boxed_in_is_boxed_in`, of frontiers that as a whole are so near to the base station that
    no relay is needed: within `home_link` times the range of the radio, less two cells. It is not
    checked where walls weaken links.

    Cost: a few overlays for each such robot.
    """
    spec = run.recording.spec
    if spec.base is None or spec.radio.walls != "pass" or spec.radio.range_m is None:
        return None
    for robot, end in sorted(run.ends.items(), key=lambda item: item[1].time_s):
        if not end.reason.startswith(NO_CHAIN) or not _may_judge(run, robot):
            continue
        slack_m = 2.0 * run.options["cell_m"]
        link_m = run.options["home_link"] * spec.radio.range_m - slack_m
        names, reach = known_at(run, robot, end), reach_of(run, robot)
        whole = shapely.get_parts(frontiers(run, robot, names, reach, slack_m))
        heard = shapely.Point(spec.base.place).buffer(max(link_m, 0.0))
        near = shapely.union_all(whole[shapely.covered_by(whole, heard)])
        bodies = bodies_around(run, robot, [end.time_s], 1.5 * run.options["body_stays_s"])
        at = run.tracks[robot].pose(end.time_s)
        found = open_frontiers(run, robot, names, reach, at, obstacles=bodies, only=near)
        for left in found:
            if left.behind_m2 >= MIN_BEHIND_M2:
                return _violation(CHAIN, robot, end, left)
    return None


def _may_judge(run: JudgedRun, robot: int) -> bool:
    if run.family == "other" or run.recording.spec.robots[robot].drive.is_car:
        return False
    if math.isfinite(run.present_s(robot)[1]):
        return False
    shown_m = run.recording.spec.robots[robot].range_finder.free_reach_m
    if shown_m <= reach_of(run, robot).off_walls_m:
        return False
    if run.family == "frontier":
        return bool(run.options["shape"] != "ball")
    return bool(run.options["gaps_count"])


def _violation(name: str, robot: int, end: Ended, left: OpenFrontier) -> Violation:
    (px, py), (sx, sy) = left.place, left.stand
    return Violation(
        invariant=name,
        says=f"robot {robot} ended at {end.time_s:.2f} s ({quoted(end.reason)}), but could go to "
        f"({sx:.2f}, {sy:.2f}) and see {left.length_m:.2f} m of frontier at ({px:.2f}, {py:.2f}), "
        f"{left.behind_m2:.2f} m2 behind",
        robot=robot,
        time_s=end.time_s,
    )


def known_at(run: JudgedRun, robot: int, until: Ended | ArcClosed | None) -> list[NodeName]:
    """Return the nodes that a robot knew before an event; in the end of the run, with None."""
    names: dict[NodeName, None] = {}
    for event in run.recording.events:
        if event is until:
            break
        if event.robot != robot:
            continue
        if isinstance(event, NodeAdded):
            names[robot, event.serial] = None
        elif isinstance(event, Learned):
            names.update(dict.fromkeys((name[0], name[1]) for name in event.nodes))
    return list(names)


def _left(
    run: JudgedRun,
    robot: int,
    names: list[NodeName],
    at_s: float,
    obstacles: BaseGeometry | None = None,
) -> list[OpenFrontier]:
    """Return what a robot could still open at a time.

    Parameters
    ----------
    run, robot, names
        The run, the robot, and what it knows.
    at_s : float
        The time (s).
    obstacles : geometry, optional
        Places where its reference point cannot be.
    """
    if run.family == "srt":
        return _left_by_srt(run, robot, names, at_s, obstacles)
    at = run.tracks[robot].pose(at_s)
    found = open_frontiers(run, robot, names, reach_of(run, robot), at, obstacles=obstacles)
    return [one for one in found if one.behind_m2 >= MIN_BEHIND_M2]


def _left_by_srt(
    run: JudgedRun,
    robot: int,
    names: list[NodeName],
    at_s: float,
    obstacles: BaseGeometry | None,
) -> list[OpenFrontier]:
    """Return what a robot of the SRT family could still open, of its own tree; as for `_left`."""
    reach, at = reach_of(run, robot), run.tracks[robot].pose(at_s)
    near_m = 3.0 * reach.scrap_m
    looked = _looked_from(run, robot, names)

    def left(only: BaseGeometry) -> list[OpenFrontier]:
        found = open_frontiers(
            run, robot, names, reach, at, obstacles=obstacles, looked=looked, only=only
        )
        return [
            one
            for one in found
            if one.behind_m2 >= MIN_BEHIND_M2
            and _is_led_to(run, robot, names, one.stand, obstacles)
            and not _shows_hardly_more(run, robot, names, one)
        ]

    own = [name for name in names if _root(run, name) == (robot, 0)]
    # The border of all that is known, where it is that of the own tree.
    own_border = united(run, own).boundary.buffer(SAME_BORDER_M, quad_segs=2)
    border = united(run, names).boundary.intersection(own_border)
    # Where borders of two trees part, shorter pieces are those of both.
    pieces = [piece for piece in stretches(border) if piece.length >= near_m]
    only: BaseGeometry = shapely.union_all(pieces).simplify(0.01).buffer(near_m, quad_segs=2)
    if _gives_up_early(run, robot):
        seen = _closed_arcs(run.recording.of(ArcClosed), "seen from near")
        only = without(only, seen.buffer(near_m, quad_segs=2))
    # What it rightly gave up is found last, as that takes longest.
    return left(only) and left(without(only, _was_out_of_reach(run, robot, reach, near_m)))


def _is_led_to(
    run: JudgedRun,
    robot: int,
    names: list[NodeName],
    stand: tuple[float, float],
    obstacles: BaseGeometry | None,
) -> bool:
    # Whether a path of the SRT family leads to a place: straight from a node, or over a raster.
    space = standing_space(run, robot, names, reach_of(run, robot), obstacles)
    nodes = [run.nodes[name].configuration[:2] for name in names]
    straight = shapely.linestrings([[node, stand] for node in nodes])
    if shapely.covered_by(straight, space.buffer(ROUNDING_M)).any():
        return True
    wide_m = SRT_RASTER * run.bodies[robot].circumscribed_m
    wide = shapely.get_parts(space.buffer(-wide_m, quad_segs=4))
    near = wide[shapely.dwithin(wide, shapely.Point(stand), wide_m + ROUNDING_M)]
    begins = shapely.multipoints(nodes)
    return bool(shapely.dwithin(near, begins, wide_m + ROUNDING_M).any())


def _was_out_of_reach(run: JudgedRun, robot: int, reach: Reach, near_m: float) -> BaseGeometry:
    # The surroundings of arcs that a robot gave up as not reachable when it could not reach them.
    around = []
    for closed in run.recording.of(ArcClosed):
        if closed.robot != robot or closed.reason != "not reachable":
            continue
        names = known_at(run, robot, closed)
        near = _closed_arcs([closed], "not reachable").buffer(near_m, quad_segs=2)
        at, looked = run.tracks[robot].pose(closed.time_s), _looked_from(run, robot, names)
        if not open_frontiers(run, robot, names, reach, at, looked=looked, only=near):
            around.append(near)
    return shapely.union_all(around)


def reach_of(run: JudgedRun, robot: int) -> Reach:
    """Return how the rules of a robot limit where it goes, and what it takes as frontier."""
    spec, body, options = run.recording.spec.robots[robot], run.bodies[robot], run.options
    finder = spec.range_finder
    # Regions of others, with other range finders, count as its own.
    blind_m = max(_blind_m(robot.range_finder) for robot in run.recording.spec.robots)
    blinder_m = blind_m - _blind_m(finder)
    width_m = body.width_m
    if run.family == "srt":
        if run.recording.spec.strategy != "srt-radial":
            blind_m = max(blind_m, options["contact_tolerance_m"])
        off_m = body.circumscribed_m + options["margin_m"] + SRT_SLACK_M
        return Reach(
            off_walls_m=off_m,
            off_unknown_m=off_m,
            enters_m=off_m,
            scrap_m=SRT_SCRAP_M,
            blind_m=blind_m,
            sees_m=finder.range_m - SRT_MIN_EXCESS_M,
            min_frontier_m=width_m + SRT_MIN_EXCESS_M,
            is_ball=run.recording.spec.strategy == "srt-ball",
        )
    cell_m, min_frontier_m = options["cell_m"], options["min_frontier_m"]
    # What a laser takes for a wall narrows passages on the raster.
    off_m = body.circumscribed_m + options["margin_m"] + 2.0 * cell_m + blind_m
    return Reach(
        off_walls_m=off_m,
        off_unknown_m=1.5 * cell_m,
        enters_m=off_m - blinder_m,
        scrap_m=cell_m,
        blind_m=blind_m and blind_m + cell_m,
        sees_m=min(3.0 * cell_m, finder.range_m),
        min_frontier_m=math.sqrt(2.0) * (width_m if min_frontier_m is None else min_frontier_m)
        + CELLS_BEYOND * cell_m,
    )


def _blind_m(finder: RangeFinderSpec) -> float:
    # How far beside a wall a laser takes for a wall what may not be one.
    if finder.beams is None:
        return 0.0
    less = math.tan(math.pi / finder.beams) / math.tan(SHARPEST_RAD / 2.0)
    return BLIND * finder.range_m * less


def _blocked_s(run: JudgedRun, robot: int) -> list[float]:
    # When it found that bodies block the path to an arc.
    closed = run.recording.of(ArcClosed)
    return [e.time_s for e in closed if e.robot == robot and e.reason == "blocked by a robot"]


def bodies_around(
    run: JudgedRun, robot: int, times_s: list[float], belief_s: float
) -> BaseGeometry:
    """Return where a robot cannot be for the bodies of others, within a while before some times."""
    options = run.options
    slack_m = BODY_SLACK_M + 2.0 * options.get("cell_m", 0.0)
    keep_m = run.bodies[robot].circumscribed_m + 1.2 * options["guard_m"] + slack_m
    taken = []
    for end_s in times_s:
        times = np.append(np.arange(max(0.0, end_s - belief_s), end_s, 0.5), [end_s, end_s])
        for other in run.robots:
            if other != robot:
                path = shapely.LineString(run.tracks[other].at(times)[:, :2])
                taken.append(path.buffer(keep_m + run.bodies[other].circumscribed_m))
    return shapely.union_all(taken)


def _is_beside_a_body(run: JudgedRun, robot: int, at_s: float) -> bool:
    # Whether a robot stands where no path may pass for the body of another one.
    place = shapely.Point(run.tracks[robot].pose(at_s)[:2])
    return bool(bodies_around(run, robot, [at_s], 0.0).covers(place))


def _gives_up_early(run: JudgedRun, robot: int) -> bool:
    # Whether the third stage gives up a spot by its rules that a few views do not show.
    if run.recording.spec.strategy == "srt-ball":
        return True
    is_large = _d_min_m(run, robot) > run.bodies[robot].width_m
    return is_large or run.options["max_views"] < DEFAULT_VIEWS


def _d_min_m(run: JudgedRun, robot: int) -> float:
    given: float | None = run.options["d_min_m"]
    if given is not None:
        return given
    share = 0.5 if run.recording.spec.strategy == "srt-ball" else 1.0
    return share * run.bodies[robot].width_m


def _shows_hardly_more(
    run: JudgedRun, robot: int, names: list[NodeName], left: OpenFrontier
) -> bool:
    # Whether an arc was given up as seen from near, and a scan from where it is seen shows so
    # little of what is unknown that the third stage does not count it.
    d_min_m = _d_min_m(run, robot)
    seen = _closed_arcs(run.recording.of(ArcClosed), "seen from near")
    if not shapely.dwithin(seen, shapely.Point(left.place), d_min_m):
        return False
    spec, (x, y) = run.recording.spec, left.stand
    range_m = spec.robots[robot].range_finder.range_m
    index = run.once(("index", range_m), lambda: EdgeIndex(run.environment.edges, range_m / 3.0))
    region = local_safe_region(
        measured(spec.robots[robot], index, Configuration(x, y, 0.0), 0.0),
        cast(Shape, spec.strategy.removeprefix("srt-")),
        cones=run.options["cones"],
        contact_tolerance_m=run.options["contact_tolerance_m"],
    )
    shown = solid(shapely.make_valid(shapely.Polygon(region.boundary)))
    more = without(shown, united(run, names))
    return bool(more.area < max(d_min_m**2, MIN_BEHIND_M2))


def _closed_arcs(closings: Iterable[ArcClosed], reason: str) -> BaseGeometry:
    # The arcs that were closed for a reason.
    segments = [s for closed in closings if closed.reason == reason for s in closed.arc]
    return shapely.MultiLineString(np.array(segments).reshape(-1, 2, 2).tolist())


def _looked_from(run: JudgedRun, robot: int, names: list[NodeName]) -> BaseGeometry:
    # Around nodes, where the third stage of the planner of the SRT family takes no place.
    d_min_m = _d_min_m(run, robot)
    places = shapely.points(np.array([run.nodes[name].configuration[:2] for name in names]))
    near_m = (run.options["completion_spacing"] + SRT_LATTICE) * d_min_m + SRT_SLACK_M
    return shapely.union_all(shapely.buffer(places, near_m))


def _root(run: JudgedRun, name: NodeName) -> NodeName:
    while (parent := run.nodes[name].parent) is not None:
        name = parent[0], parent[1]
    return name


def _is_walled_in(run: JudgedRun, robot: int, end: Ended) -> bool:
    # Whether it never left a start where its first scan shows less room than it keeps.
    if not end.reason.startswith(WALLED_IN):
        return False
    start = run.recording.starts[robot][:2]
    for motion in run.recording.of(Motion):
        if motion.robot == robot and math.dist(motion.waypoints[-1][1:3], start) > LEFT_M:
            return False
    reach = reach_of(run, robot)
    keeps_m = reach.off_walls_m - (reach.blind_m if run.family == "frontier" else 0.0)
    shown = run.regions[robot, 0].exterior
    return bool(shown.distance(shapely.Point(start)) <= keeps_m)


def _is_jammed(run: JudgedRun, robot: int, end: Ended) -> bool:
    # Whether it may have ended as attempts to pass others failed too often.
    tries = 0
    for event in _until(run, end):
        match event:
            case Sent() if run.family == "frontier" and event.kind == "give way":
                tries += event.robot == robot or robot in event.reached
            case Blocked() | Coordinated() if run.family == "srt" and event.robot == robot:
                tries += isinstance(event, Blocked) or event.order != "keep"
    most: int = run.options["max_jams" if run.family == "frontier" else "gives_up_after"]
    return tries >= most


def _until(run: JudgedRun, end: Ended) -> Iterator[object]:
    for event in run.recording.events:
        if event is end:
            return
        yield event
