"""Pictures of Sensor-based Random Trees: regions, frontier arcs, and the stages of the planner."""

from __future__ import annotations

import math

import numpy as np
import shapely
from setting import BODY, FLAT, RANGE_M, region_at
from sketch import Sketch

from multisrt.environments.environment import Environment
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.boundary import CUT, GAP, OBSTACLE, RANGE
from multisrt.geometry.regions.safe_region import LocalSafeRegion, Shape
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Holonomic
from multisrt.planners.srt import SrtOptions, SrtPlanner
from multisrt.robots.exploration_map import ExplorationMap
from multisrt.robots.knowledge import Node, NodeId

BOUNDS = (0.0, 0.0, 14.0, 8.4)
TAGS = {OBSTACLE: "obstacle", RANGE: "range", GAP: "gap", CUT: "cut"}


def pieces(region: LocalSafeRegion, tag: int) -> FloatArray:
    """Return the pieces of a region's boundary with a tag, ``(m, 4)``."""
    ends = np.roll(region.boundary, -1, axis=0)
    return np.hstack([region.boundary, ends])[region.tags == tag]


def map_of(
    places: list[tuple[float, float]], min_arc_m: float = 0.5, environment: Environment = FLAT
) -> ExplorationMap:
    """Return the map of a robot that has taken scans at some places, one after another."""
    known = ExplorationMap(reach_m=RANGE_M, min_arc_m=min_arc_m)
    for k, (x, y) in enumerate(places):
        known.add(
            Node(
                id=NodeId(0, k),
                configuration=Configuration(x, y),
                region=region_at(environment, x, y),
                parent=NodeId(0, k - 1) if k else None,
                time_s=float(k),
            )
        )
    return known


# Local safe regions ------------------------------------------------------------------------


def region(shape: Shape, title: str) -> str:
    """Draw one region, its boundary by tags."""
    sketch = Sketch(title, (0.0, 0.0, 9.2, 8.4))
    x, y = 3.6, 3.6
    found = region_at(FLAT, x, y, shape)
    sketch.area(found.polygon(), "region")
    sketch.walls(FLAT)
    sketch.circle(x, y, RANGE_M)
    if shape == "star":
        for k in range(16):
            angle = 2.0 * math.pi * k / 16
            end = x + RANGE_M * math.cos(angle), y + RANGE_M * math.sin(angle)
            sketch.line([(x, y), end], "thin")
    for tag, style in TAGS.items():
        if len(pieces(found, tag)):
            sketch.segments(pieces(found, tag), style)
            sketch.sample(style, style)
    sketch.dot(x, y, "robot")
    return sketch.svg()


def radial() -> str:
    """Draw the radial region."""
    return region("radial", "Radial region: the whole visibility polygon")


def star() -> str:
    """Draw the star."""
    return region("star", "Star: each of 16 cones is cut at its smallest reading")


def ball() -> str:
    """Draw the ball."""
    return region("ball", "Ball: a disc of the smallest reading")


# Frontier arcs -----------------------------------------------------------------------------

FIRST, SECOND = (3.6, 3.6), (6.2, 3.9)


def candidates() -> str:
    """Draw the pieces of one region that are not obstacles."""
    sketch = Sketch("The pieces of a region's boundary that end at no obstacle", BOUNDS)
    found = region_at(FLAT, *FIRST)
    sketch.area(found.polygon(), "region")
    sketch.walls(FLAT)
    sketch.segments(pieces(found, OBSTACLE), "obstacle")
    for tag in (RANGE, GAP):
        sketch.segments(pieces(found, tag), "frontier")
    sketch.dot(*FIRST, "robot")
    sketch.sample("obstacle", "obstacle")
    sketch.sample("frontier", "frontier arc")
    return sketch.svg()


def free_arcs() -> str:
    """Draw what a second region takes from the arcs of the first."""
    sketch = Sketch("A second region takes from the arcs what lies in its interior", BOUNDS)
    known = map_of([FIRST, SECOND])
    second = region_at(FLAT, *SECOND)
    sketch.area(region_at(FLAT, *FIRST).polygon(), "region")
    sketch.area(second.polygon(), "other")
    sketch.walls(FLAT)
    first = region_at(FLAT, *FIRST)
    before = shapely.union_all(
        [
            shapely.LineString([p[:2], p[2:]])
            for p in np.vstack([pieces(first, RANGE), pieces(first, GAP)])
        ]
    )
    inside = before.intersection(second.polygon())
    for part in shapely.get_parts(inside):
        if isinstance(part, shapely.LineString):
            sketch.line(part.coords, "free")
    for k in range(2):
        sketch.segments(known.frontier(NodeId(0, k)), "frontier")
    sketch.line([FIRST, SECOND], "bold")
    sketch.dot(*FIRST, "target")
    sketch.dot(*SECOND, "robot")
    sketch.sample("free", "free arc")
    sketch.sample("frontier", "frontier arc")
    sketch.sample("target", "node")
    return sketch.svg()


def short_arcs() -> str:
    """Draw the arcs that are shorter than the body is wide."""
    sketch = Sketch("Arcs shorter than the body's width cannot be passed and are left out", BOUNDS)
    at = (4.0, 3.4)
    everything = map_of([at], min_arc_m=0.0).frontier(NodeId(0, 0))
    kept = map_of([at], min_arc_m=1.0).frontier(NodeId(0, 0))
    sketch.area(region_at(FLAT, *at).polygon(), "region")
    sketch.walls(FLAT)
    sketch.segments(everything, "cut")
    sketch.segments(kept, "frontier")
    sketch.circle(*at, 0.5, "outline")
    sketch.dot(*at, "robot", 3.0)
    sketch.sample("frontier", "frontier arc")
    sketch.sample("cut", "shorter than the body")
    sketch.sample("outline", "a body 1 m wide")
    return sketch.svg()


# The planner -------------------------------------------------------------------------------


def planner() -> SrtPlanner:
    """Return the planner of a disc that moves in any direction."""
    body = PlanningBody(BODY, margin_m=0.02)
    return SrtPlanner(body, Holonomic(), SrtOptions(), d_min_m=BODY.width_m)


def draw() -> str:
    """Draw stage 1: candidates at a share of the distance to the boundary."""
    places = [(6.7, 2.9), (3.4, 1.2), (3.9, 2.0)]
    known = map_of(places)
    at = Configuration(*places[-1])
    own = region_at(FLAT, *places[-1])
    frontier = known.frontier(NodeId(0, 2))
    place, draws = planner().draw(at, own, frontier, np.array(places), [], np.random.default_rng(3))
    assert place is not None
    sketch = Sketch("Stage 1: candidates are drawn towards the local frontier", BOUNDS)
    sketch.area(own.polygon(), "region")
    sketch.walls(FLAT)
    for k in range(2):
        sketch.segments(known.frontier(NodeId(0, k)), "free")
    sketch.segments(frontier, "frontier")
    for x, y, reason in draws.candidates:
        sketch.line([at[:2], (x, y)], "refused")
        sketch.cross(x, y)
        sketch.text(x, y, reason, dy=-13)
    sketch.line([at[:2], place], "path")
    sketch.dot(*place, "chosen", 6)
    for node in places[:-1]:
        sketch.dot(*node, "target")
    sketch.dot(*at[:2], "robot")
    sketch.sample("frontier", "local frontier")
    sketch.sample("free", "frontier of other nodes")
    sketch.sample("target", "node")
    sketch.sample("refused", "refused")
    sketch.sample("chosen", "accepted")
    return sketch.svg()


def approach() -> str:
    """Draw stage 2: a door that is seen edge-on."""
    places = [(3.4, 2.4), (6.55, 1.3)]
    known = map_of(places)
    at = Configuration(*places[-1])
    own = region_at(FLAT, *places[-1])
    arcs = known.frontier_arcs(NodeId(0, 1))
    place = planner().approach(at, own, arcs, np.array(places))
    assert place is not None
    sketch = Sketch("Stage 2: the reachable place nearest to a frontier arc", BOUNDS)
    sketch.area(own.polygon(), "region")
    sketch.walls(FLAT)
    for arc in arcs:
        sketch.segments(arc, "frontier")
    sketch.line(places, "bold")
    sketch.line([at[:2], place], "path")
    sketch.dot(*place, "chosen", 6)
    sketch.dot(*places[0], "target")
    sketch.dot(*at[:2], "robot")
    sketch.sample("frontier", "local frontier")
    sketch.sample("chosen", "the place")
    sketch.sample("target", "node")
    return sketch.svg()


def complete() -> str:
    """Draw stage 3: a place from which a remaining arc is seen."""
    places = [(3.4, 2.4), (5.9, 3.9), (8.6, 3.9), (8.6, 6.4), (3.2, 6.9)]
    known = map_of(places)
    left = [(n, arc) for n in known.open_nodes() for arc in known.frontier_arcs(n)]
    _, arc = max(left, key=lambda item: float(item[1][:, 1].max()) * (item[0].serial == 4))
    x, y = arc[len(arc) // 2, :2]
    nodes = known.near(x, y, 2.0 * RANGE_M)
    found = planner().viewing_place(arc, known.known_space(x, y, 2.0 * RANGE_M), RANGE_M, nodes)
    assert not isinstance(found, str), found
    sketch = Sketch("Stage 3: a known place from which a remaining arc is seen", BOUNDS)
    for place in places:
        sketch.area(region_at(FLAT, *place).polygon(), "region")
    sketch.walls(FLAT)
    for _, other in left:
        sketch.segments(other, "free")
    sketch.segments(arc, "frontier")
    sketch.line(places[:4], "bold")
    sketch.line([places[0], places[4]], "bold")
    start = nodes[found.node].configuration
    sketch.line([start[:2], (found.x, found.y)], "path")
    sketch.segments([(found.x, found.y, x, y)], "thin")
    for place in places[1:]:
        sketch.dot(*place, "target")
    sketch.dot(found.x, found.y, "chosen", 6)
    sketch.dot(*places[0], "robot")
    sketch.sample("frontier", "the arc")
    sketch.sample("free", "other arcs left")
    sketch.sample("chosen", "viewing place")
    sketch.sample("robot", "robot, back at its root")
    return sketch.svg()


FIGURES = {
    "safe-regions-radial": radial,
    "safe-regions-star": star,
    "safe-regions-ball": ball,
    "frontier-arcs-candidates": candidates,
    "frontier-arcs-free": free_arcs,
    "frontier-arcs-short": short_arcs,
    "srt-planner-draw": draw,
    "srt-planner-approach": approach,
    "srt-planner-complete": complete,
}
