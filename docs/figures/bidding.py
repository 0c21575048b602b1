"""Pictures of frontier bidding: groups, costs, and what each rule makes of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

import numpy as np
import shapely
from setting import BODY, FLAT, FLOOR, RANGE_M, region_at
from sketch import Sketch, squares

from multisrt.drawing.colours import tint
from multisrt.environments.environment import Environment
from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.grid_path import shortest_path
from multisrt.geometry.grids.occupancy import FREE, OCCUPIED, Occupancy
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.line_of_sight import line_of_sight
from multisrt.planners.assignment.cell_choice import choose_cell
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.costs import DenseCosts
from multisrt.planners.assignment.exchange import exchange
from multisrt.planners.assignment.greedy import greedy
from multisrt.planners.assignment.minpos import minpos
from multisrt.planners.assignment.positions import positions
from multisrt.planners.assignment.self_bidding import CohesionRadii, SelfBid, self_bidding
from multisrt.planners.assignment.utility import utility

CELL_M = 0.1
BOUNDS = (0.0, 0.0, 18.0, 10.0)
SCANS = [(3.0, 5.1), (6.2, 5.0), (9.6, 5.1), (7.7, 7.2)]
ROBOTS = [(2.2, 5.3), (6.6, 4.8), (7.3, 5.3), (10.2, 4.8)]
SCENES = {
    "floor": (FLOOR, SCANS, ROBOTS),
    "room": (FLAT, [(3.6, 3.6)], [(2.8, 2.9), (4.4, 4.4), (4.9, 2.6)]),
}


@dataclass(frozen=True)
class Scene:
    """The common knowledge of some robots."""

    world: Environment
    scans: list[tuple[float, float]]
    robots: list[tuple[float, float]]
    raster: Occupancy
    targets: FloatArray
    costs: FloatArray
    paths: list[list[FloatArray]]


def paths_from(
    raster: Occupancy, places: Iterable[tuple[float, float]], rows: IntArray
) -> tuple[FloatArray, list[list[FloatArray]]]:
    """Return the lengths of the shortest paths from each place to some cells, and the paths."""
    lengths, paths = [], []
    for place in places:
        field = DistanceField(raster.passable, CELL_M, [place], x0=raster.x0, y0=raster.y0)
        lengths.append(field.distance(rows))
        paths.append([shortest_path(field, row) for row in rows])
    return np.array(lengths), paths


@cache
def scene(name: str = "floor") -> Scene:
    """Return the map, the frontier groups' targets, and the costs of robots to them."""
    world, scans, places = SCENES[name]
    raster = Occupancy(CELL_M, BODY.radius_m)
    for x, y in scans:
        raster.add(region_at(world, x, y))
    groups = [g for g in raster.frontier_groups(BODY.width_m) if g.target is not None]
    cells = np.array([g.target for g in groups])
    rows = np.stack(raster.indices_of(cells), axis=1)
    costs, paths = paths_from(raster, places, rows)
    targets = raster.centres_of(cells)
    return Scene(world, scans, places, raster, targets, costs, paths)


def ground(title: str, of: str = "floor") -> Sketch:
    """Return a sketch of the known part of a world."""
    known = scene(of)
    x0, y0, x1, y1 = known.world.bounds
    sketch = Sketch(title, (x0 - 0.2, y0 - 0.2, x1 + 0.2, y1 + 0.2))
    seen = shapely.union_all([region_at(known.world, x, y).polygon() for x, y in known.scans])
    sketch.area(seen, "known")
    return sketch


def frontiers(sketch: Sketch, of: str = "floor", *, names: bool = True) -> None:
    """Draw walls, the groups of frontier cells and their targets."""
    sketch.walls(scene(of).world)
    raster = scene(of).raster
    for group in raster.frontier_groups(BODY.width_m):
        sketch.cells(raster.centres_of(group.cells), CELL_M, "cell")
    for j, (x, y) in enumerate(scene(of).targets.tolist()):
        sketch.dot(x, y, "target", 4)
        if names:
            sketch.text(x, y, f"F{j}", dy=-13)


def robots(sketch: Sketch, of: str = "floor") -> None:
    """Draw the robots."""
    for i, (x, y) in enumerate(scene(of).robots):
        sketch.dot(x, y, f"r{i}", 8)
        sketch.text(x, y, str(i))


def chosen_paths(sketch: Sketch, chosen: list[int | None], of: str = "floor") -> None:
    """Draw the path of each robot to its frontier."""
    for i, j in enumerate(chosen):
        if j is not None and j >= 0:
            sketch.line(scene(of).paths[i][j], f"l{i}")


# Groups and costs --------------------------------------------------------------------------


def centres(raster: Occupancy, where: BoolArray) -> FloatArray:
    """Return the centres of some cells of a raster's window, ``(n, 2)``."""
    return raster.centres_of(np.argwhere(where) + np.array([raster.row, raster.column]))


def cells() -> str:
    """Draw the states of the cells."""
    sketch = Sketch("Cells: free, occupied, unknown; where the body can stand", BOUNDS)
    raster = scene().raster
    for found, style in (
        (raster.cells == FREE, "other"),
        (raster.passable, "a2"),
        (raster.cells == OCCUPIED, "wall"),
    ):
        sketch.cells(centres(raster, found), CELL_M, style)
    for x, y in SCANS:
        sketch.dot(x, y, "robot", 3.5)
    sketch.sample("other", "free")
    sketch.sample("a2", "passable")
    sketch.sample("wall", "occupied")
    sketch.sample("robot", "scan")
    return sketch.svg()


def groups() -> str:
    """Draw the groups and their targets."""
    sketch = ground("Frontier groups: 8-connected frontier cells, each with a target")
    frontiers(sketch)
    sketch.sample("cell", "frontier cells")
    sketch.sample("target", "target of the group")
    return sketch.svg()


def costs() -> str:
    """Draw the distance field of one robot, and its shortest paths."""
    sketch = Sketch("Costs: lengths of shortest paths, from one distance field", BOUNDS)
    raster = scene().raster
    field = DistanceField(raster.passable, CELL_M, [ROBOTS[0]], x0=raster.x0, y0=raster.y0)
    field.complete()
    reached = field.reached()
    for k in range(14):
        band = (reached >= k) & (reached < k + 1)
        if band.any():
            found = centres(raster, band)
            sketch.fill(squares(found, CELL_M), tint("#0072b2", 0.1 + 0.05 * (k % 2) + 0.03 * k))
    frontiers(sketch, names=False)
    for j, path in enumerate(scene().paths[0]):
        sketch.line(path, "path")
        x, y = scene().targets[j].tolist()
        sketch.text(x, y, f"{scene().costs[0, j]:.1f}", dy=-13)
    x, y = ROBOTS[0]
    sketch.dot(x, y, "r0", 8)
    sketch.text(x, y, "0")
    sketch.sample("path", "shortest path; its length in metres (bands of 1 m)")
    return sketch.svg()


# The rules ---------------------------------------------------------------------------------


def by_closest() -> str:
    """Draw what CLOSEST chooses."""
    oracle = DenseCosts(scene().costs)
    sketch = ground("CLOSEST: every robot to its nearest frontier")
    frontiers(sketch)
    chosen_paths(sketch, [closest(oracle, i) for i in range(len(ROBOTS))])
    robots(sketch)
    return sketch.svg()


def by_greedy() -> str:
    """Draw what GREEDY assigns, in order."""
    found = greedy(DenseCosts(scene().costs))
    sketch = ground("GREEDY: always the cheapest pair that is left")
    frontiers(sketch)
    chosen_paths(sketch, found.assignment.tolist())
    robots(sketch)
    for k, pair in enumerate(found.rounds, 1):
        sketch.sample(
            f"l{pair.robot}", f"{k}: robot {pair.robot} to F{pair.frontier}, {pair.cost_m:.1f} m"
        )
    return sketch.svg()


def ranks() -> str:
    """Draw the positions of one robot."""
    table = positions(scene().costs)
    sketch = ground("Positions: how many robots are nearer to a frontier than this one")
    frontiers(sketch, names=False)
    for j, (x, y) in enumerate(scene().targets.tolist()):
        sketch.text(x, y, f"{table[2, j]} nearer", dy=-13)
        for i in range(len(ROBOTS)):
            if table[i, j] < table[2, j]:
                sketch.line(scene().paths[i][j], f"d{i}")
    robots(sketch)
    sketch.sample("r2", "robot 2, whose positions these are")
    sketch.sample("path", "robots that are nearer")
    return sketch.svg()


def by_minpos() -> str:
    """Draw what MINPOS chooses."""
    oracle = DenseCosts(scene().costs)
    chosen = [minpos(oracle, i).choice for i in range(len(ROBOTS))]
    table = positions(scene().costs)
    sketch = ground("MINPOS: to the frontier to which the fewest robots are nearer")
    frontiers(sketch)
    chosen_paths(sketch, chosen)
    robots(sketch)
    for i, j in enumerate(chosen):
        sketch.sample(f"l{i}", f"robot {i}: F{j}, {table[i, j]} nearer")
    return sketch.svg()


def by_utility() -> str:
    """Draw what UTILITY assigns, and how an assignment lowers the utility near by."""
    targets, costs = scene("room").targets, scene("room").costs
    index = EdgeIndex(FLAT.edges, 2.0)
    distances = np.hypot(*(targets[:, None] - targets[None]).transpose(2, 0, 1))
    sees = np.array(
        [[a is b or line_of_sight(index, *a, *b) for b in targets.tolist()] for a in targets]
    )
    found = utility(costs, distances, sees, 2.0 * RANGE_M)
    sketch = ground("UTILITY: an assigned target lowers the utility of those that it sees", "room")
    _, first, _, _ = found.rounds[0]
    frontiers(sketch, "room")
    for j, place in enumerate(targets):
        if j != first and sees[first, j] and distances[first, j] < 2 * RANGE_M:
            sketch.line([targets[first], place], "path")
    chosen_paths(sketch, found.assignment.tolist(), "room")
    robots(sketch, "room")
    for k, (i, j, worth, share) in enumerate(found.rounds, 1):
        sketch.sample(f"l{i}", f"{k}: robot {i} to F{j}, U {worth:.2f}, V {share:.2f}")
    sketch.sample("path", f"in view of F{first}, the first, and nearer than 2 R")
    return sketch.svg()


# SBX-R -------------------------------------------------------------------------------------

RADIO_M = 7.0
BIDDER = 2
GOALS = [5, 2, None, 4]


def goals() -> FloatArray:
    """Return where the robots are bound; the bidder has reached its goal."""
    targets = scene().targets
    return np.array(
        [ROBOTS[i] if j is None else targets[j % len(targets)] for i, j in enumerate(GOALS)]
    )


@cache
def bid() -> tuple[SelfBid, FloatArray]:
    """Return the bids of one robot, and the gaps of its paths."""
    raster, targets = scene().raster, scene().targets
    cells = raster.cells_of(targets)
    rows = np.stack(raster.indices_of(cells), axis=1)
    rho = np.zeros(len(ROBOTS))
    onward = np.empty((len(ROBOTS), len(targets)))
    path_gap = np.empty_like(onward)
    for i, goal in enumerate(goals()):
        field = DistanceField(raster.passable, CELL_M, [goal], x0=raster.x0, y0=raster.y0)
        onward[i] = field.distance(rows)
        own = raster.cells_of([ROBOTS[i]])
        rho[i] = field.distance(np.stack(raster.indices_of(own), axis=1))[0]
        others = np.delete(goals(), i, axis=0)
        for j, row in enumerate(rows):
            points = shortest_path(field, row)
            if np.ptp(points, axis=0).any():
                points = shapely.get_coordinates(shapely.LineString(points).segmentize(0.1))
            away = np.hypot(*(points[:, None] - others[None]).transpose(2, 0, 1))
            path_gap[i, j] = away.min(axis=1).max()
    places = np.array(ROBOTS)
    frontier_gap = np.empty_like(onward)
    for i in range(len(ROBOTS)):
        away = np.hypot(*(targets[:, None] - np.delete(places, i, axis=0)[None]).transpose(2, 0, 1))
        frontier_gap[i] = away.min(axis=1)
    radii = CohesionRadii(range_m=RADIO_M, diagonal_m=raster.diagonal_m)
    return self_bidding(BIDDER, rho, onward, path_gap, frontier_gap, radii), path_gap


def cohesion() -> str:
    """Draw the radius of cohesion, and which frontiers it leaves to the bidder."""
    found, _ = bid()
    sketch = ground("Cohesion: which frontiers a robot may bid for")
    frontiers(sketch, names=False)
    for i, goal in enumerate(goals()):
        if i != BIDDER:
            sketch.circle(*goal, found.phi_m)
            sketch.line([ROBOTS[i], goal], f"d{i}")
    for j, (x, y) in enumerate(scene().targets.tolist()):
        offer = found.bids[BIDDER, j]
        sketch.text(x, y, f"{offer:+.1f}" if np.isfinite(offer) else "inf", dy=-13)
    robots(sketch)
    sketch.sample("circle", f"phi = {found.phi_m:.1f} m around others' goals")
    sketch.sample("r2", "robot 2 bids (m)")
    return sketch.svg()


def matching() -> str:
    """Draw the matching of the least sum of bids."""
    found, _ = bid()
    sketch = ground("Matching: the least sum of all robots' bids")
    frontiers(sketch)
    for i, j in enumerate(found.matching.tolist()):
        if j >= 0:
            sketch.line([goals()[i], scene().targets[j]], f"d{i}")
            sketch.sample(f"d{i}", f"robot {i}: F{j}, {found.bids[i, j]:+.1f} m")
    if found.choice is not None:
        sketch.line(scene().paths[BIDDER][found.choice], f"l{BIDDER}")
        sketch.sample(f"l{BIDDER}", f"the bidder goes to F{found.choice}")
    robots(sketch)
    return sketch.svg()


# Álvarez's rules ---------------------------------------------------------------------------

WIDE_M = 0.5


def survey() -> tuple[FloatArray, FloatArray]:
    """Return the centres of the unexplored cells of the search, and those of all."""
    x, y = np.meshgrid(np.arange(0.25, 18.0, WIDE_M), np.arange(0.25, 10.0, WIDE_M))
    centres = np.stack([x.ravel(), y.ravel()], axis=1)
    unknown = np.array([not scene().raster.is_known(*place) for place in centres.tolist()])
    return centres[unknown], centres


def scores() -> str:
    """Draw the scores of the unexplored cells for one robot."""
    found, _ = survey()
    x, y = ROBOTS[2]
    heading = np.pi / 2
    offset = found - (x, y)
    others = np.array([scene().targets[0], scene().targets[-1], ROBOTS[3]])
    to_goals = np.hypot(*(found[None] - others[:, None]).transpose(2, 0, 1))
    chosen = choose_cell(
        np.hypot(*offset.T),
        np.arctan2(offset[:, 1], offset[:, 0]) - heading,
        to_goals,
        len(ROBOTS),
        float(np.hypot(18.0, 10.0)),
    )
    sketch = Sketch("Scores of unexplored cells: distance, turn, and others' goals", BOUNDS)
    low, high = chosen.scores.min(), chosen.scores.max()
    level = np.floor(7.99 * ((chosen.scores - low) / (high - low)) ** 2)
    for k in np.unique(level):
        colour = tint("#009e73", 0.08 + 0.92 * k / 7.0)
        sketch.fill(squares(found[level == k], WIDE_M), colour)
    sketch.walls(FLOOR)
    for k, goal in enumerate(others.tolist()):
        sketch.dot(*goal, f"r{(0, 1, 3)[k]}", 5)
    best = found[chosen.order[0]].tolist()
    sketch.line([(x, y), (x, y + 0.8)], "bold", arrow=True)
    sketch.dot(x, y, "r2", 8)
    sketch.text(x, y, "2")
    sketch.dot(*best, "target", 6)
    sketch.text(*best, f"{chosen.scores[chosen.order[0]]:.1f}", dy=15)
    sketch.sample("target", "best cell of robot 2; dark: high scores")
    sketch.sample("r0", "goals of others")
    return sketch.svg()


def sector() -> str:
    """Draw the sector in which a robot looks for others."""
    x, y = 4.0, 5.1
    sketch = ground("The sector of 15 degrees to either side of the heading")
    sketch.walls(FLOOR)
    radius, half = 3.2, np.radians(15.0)
    angles = np.linspace(-half, half, 13)
    rim = np.stack([x + radius * np.cos(angles), y + radius * np.sin(angles)], axis=1)
    sketch.area(shapely.Polygon([(x, y), *rim.tolist()]), "a1")
    sketch.line([(x, y), (9.4, 5.1)], "d0")
    sketch.line([(6.2, 5.3), (1.0, 5.2)], "d1")
    for number, place in enumerate([(x, y), (6.2, 5.3), (10.2, 4.8)]):
        sketch.dot(*place, f"r{number}", 8)
        sketch.text(*place, str(number))
    sketch.sample("a1", "sector of robot 0, in which it meets robot 1")
    return sketch.svg()


def swap() -> str:
    """Draw an exchange of goals."""
    aims = [3, 1]
    table = np.array([[scene().costs[i, j] for j in aims] for i in (1, 2)])
    own = np.array([table[0, 0], table[1, 1]])
    partner = exchange(0, table[0], own)
    sketch = ground("Exchange: a goal that costs this robot less than its own, and its owner more")
    frontiers(sketch)
    for i, robot in enumerate((1, 2)):
        sketch.line(scene().paths[robot][aims[i]], f"d{robot}")
    for robot in (1, 2):
        sketch.dot(*ROBOTS[robot], f"r{robot}", 8)
        sketch.text(*ROBOTS[robot], str(robot))
    sketch.sample(
        "d1", f"robot 1 to F{aims[0]}: {own[0]:.1f} m; to F{aims[1]}: {table[0, 1]:.1f} m"
    )
    sketch.sample("d2", f"robot 2 to F{aims[1]}: {own[1]:.1f} m")
    sketch.sample("target", "swapped" if partner is not None else "kept")
    return sketch.svg()


FIGURES = {
    "frontier-groups-cells": cells,
    "frontier-groups-groups": groups,
    "frontier-groups-costs": costs,
    "closest": by_closest,
    "greedy": by_greedy,
    "minpos-positions": ranks,
    "minpos": by_minpos,
    "utility": by_utility,
    "self-bidding-cohesion": cohesion,
    "self-bidding-matching": matching,
    "rules-scores": scores,
    "rules-sector": sector,
    "rules-exchange": swap,
}
