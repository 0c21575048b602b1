"""Pictures of the strategies of this project, and of a chain of relays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from itertools import pairwise

import numpy as np
import shapely
from bidding import CELL_M, ROBOTS, SCANS, centres, frontiers, ground, paths_from, scene
from setting import RANGE_M, region_at
from sketch import Sketch

from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.grid_path import shortest_path
from multisrt.geometry.grids.occupancy import FREE, OCCUPIED
from multisrt.geometry.grids.rooms import room_around
from multisrt.geometry.grids.unknown_area import unknown_areas
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.assignment.gain import GainChoice, ValueParameters
from multisrt.planners.assignment.gain_tours import gain_on_tours
from multisrt.planners.assignment.team_routes import team_routes
from multisrt.planners.relay_chain import Place, relay_places
from multisrt.robots.frontier.own_room import DOORWAY_M

BASE = (0.8, 5.0)
LINK_M = 4.0
FAR = 2
"""The frontier to which the chain leads."""

TEAM = (0, 3)
"""The robots that share the frontiers: two of them, so that each takes several."""


@cache
def paths_between() -> tuple[FloatArray, list[list[FloatArray]]]:
    """Return the lengths of the paths between the targets, and the paths."""
    raster, targets = scene().raster, scene().targets
    rows = np.stack(raster.indices_of(raster.cells_of(targets)), axis=1)
    lengths, paths = paths_from(raster, targets, rows)
    return np.minimum(lengths, lengths.T), paths


@cache
def areas() -> FloatArray:
    """Return the unknown area in sight of each target, in square metres."""
    raster = scene().raster
    rows = np.stack(raster.indices_of(raster.cells_of(scene().targets)), axis=1)
    found: FloatArray = unknown_areas(raster.cells, rows, RANGE_M / CELL_M) * CELL_M**2
    return found


@cache
def chosen() -> list[GainChoice]:
    """Return what each robot chooses by GAIN."""
    targets = scene().targets
    distances = np.hypot(*(targets[:, None] - targets[None]).transpose(2, 0, 1))
    lengths, _ = paths_between()
    sight = ValueParameters(RANGE_M)
    costs = scene().costs[list(TEAM)]
    return [
        gain_on_tours(costs, areas(), distances, lengths, row, parameters=sight)
        for row in range(len(TEAM))
    ]


def in_sight() -> str:
    """Draw the unknown area in sight of each frontier."""
    sketch = ground("GAIN: the unknown area in sight of a frontier, where nothing unknown hides it")
    raster = scene().raster
    walls = shapely.MultiPoint(
        raster.centres_of(
            np.argwhere(raster.cells == OCCUPIED) + np.array([raster.row, raster.column])
        )
    ).buffer(0.5 * CELL_M, cap_style="square")
    seen = shapely.union_all([region_at(scene().world, x, y).polygon() for x, y in SCANS])
    for j, (x, y) in enumerate(scene().targets.tolist()):
        rim = []
        for angle in np.linspace(0.0, math.tau, 240, endpoint=False):
            ray = shapely.LineString(
                [(x, y), (x + RANGE_M * math.cos(angle), y + RANGE_M * math.sin(angle))]
            )
            free = shapely.get_parts(ray.difference(walls))[0]
            rim.append(free.coords[-1])
        fan = shapely.make_valid(shapely.Polygon(rim)).difference(seen.buffer(0.05))
        sketch.area(fan, f"a{j % 8}")
    frontiers(sketch, names=False)
    for (x, y), area_m2 in zip(scene().targets.tolist(), areas().tolist(), strict=True):
        sketch.text(x, y, f"{area_m2:.0f}", dy=-13)
    sketch.sample("cell", "frontiers, with the unknown area in sight (m2)")
    return sketch.svg()


def by_gain() -> str:
    """Draw what GAIN chooses: of the frontiers that a robot takes, the first of the best tour."""
    sketch = ground("GAIN: of the frontiers that a robot takes, the first one of the best tour")
    frontiers(sketch)
    for row, (i, found) in enumerate(zip(TEAM, chosen(), strict=True)):
        taken = [j for taker, j, *_ in found.rounds if taker == row]
        assert found.choice is not None
        stops = [found.choice, *(j for j in taken if j != found.choice)]
        draw_route(sketch, i, stops)
        named = ", ".join(f"F{j}" for j in taken)
        sketch.sample(f"l{i}", f"robot {i} takes {named}; goes to F{found.choice}")
    draw_team(sketch)
    return sketch.svg()


def rooms() -> str:
    """Draw the parts of the map that doorways separate."""
    sketch = ground("GAIN: parts of a robot's map that doorways separate; small ones are rooms")
    raster = scene().raster
    left, number = raster.cells == FREE, 0
    while left.any():
        row, column = np.argwhere(left)[0].tolist()
        room = room_around(raster.cells, row, column, doorway_cells=DOORWAY_M / CELL_M)
        left[row, column] = False
        if room is not None:
            left &= ~room.cells
            sketch.cells(centres(raster, room.cells), CELL_M, f"a{number % 8}")
            sketch.cells(centres(raster, room.cells & ~room.inner), CELL_M, "a7")
            number += 1
    frontiers(sketch)
    sketch.sample("cell", "frontiers")
    sketch.sample("a7", "doorways")
    sketch.sample("a0", "a part of the map")
    return sketch.svg()


def draw_route(sketch: Sketch, robot: int, stops: Sequence[int]) -> None:
    """Draw the path of a robot through some targets, dashed from the first on."""
    _, between = paths_between()
    for a, b in pairwise(stops):
        sketch.line(between[a][b], f"d{robot}")
    if stops:
        sketch.line(scene().paths[robot][stops[0]], f"l{robot}")


def draw_team(sketch: Sketch) -> None:
    """Draw the robots that share the frontiers."""
    for i in TEAM:
        sketch.dot(*ROBOTS[i], f"r{i}", 8)
        sketch.text(*ROBOTS[i], str(i))


def by_routes() -> str:
    """Draw the routes of the team."""
    lengths, _ = paths_between()
    found = team_routes(scene().costs[list(TEAM)], lengths, service_lengths=0.15 * areas())
    sketch = ground("ROUTES: routes of the whole team, the longest as short as possible")
    frontiers(sketch)
    for i, stops in zip(TEAM, found.routes, strict=True):
        draw_route(sketch, i, stops)
    draw_team(sketch)
    for i, stops, length_m in zip(TEAM, found.routes, found.lengths_m, strict=True):
        named = ", ".join(f"F{j}" for j in stops)
        sketch.sample(f"l{i}", f"robot {i}: {named}; {length_m:.0f} m with the search there")
    return sketch.svg()


def chain() -> str:
    """Draw the relays that link a frontier with the base station."""
    raster, target = scene().raster, scene().targets[FAR]
    field = DistanceField(raster.passable, CELL_M, [BASE], x0=raster.x0, y0=raster.y0)
    row = np.stack(raster.indices_of(raster.cells_of([target])), axis=1)[0]
    path = shapely.get_coordinates(shapely.LineString(shortest_path(field, row)).segmentize(0.1))

    def linked(places: FloatArray, at: Place) -> np.ndarray:
        return np.hypot(*(places - at).T) <= LINK_M

    relays = relay_places(path, BASE, linked, max_relays=len(ROBOTS) - 1)
    assert relays is not None
    sketch = ground("A chain: relays on the path from the base station to the goal of the front")
    frontiers(sketch, names=False)
    sketch.line(path, "path")
    for place in (BASE, *relays):
        sketch.circle(*place, LINK_M)
    sketch.line([BASE, *relays, target.tolist()], "l1")
    sketch.dot(*BASE, "robot", 8)
    sketch.text(*BASE, "base", dx=6, dy=17)
    for k, place in enumerate(relays, 1):
        sketch.dot(*place, f"r{k}", 8)
        sketch.text(*place, str(k))
    sketch.dot(*target.tolist(), "target", 6)
    sketch.text(*target.tolist(), "goal", dy=-15)
    sketch.sample("path", "path from the base station")
    sketch.sample("r1", "places of relays")
    sketch.sample("circle", f"reach of a link, {LINK_M:g} m")
    return sketch.svg()


FIGURES = {
    "gain-areas": in_sight,
    "gain": by_gain,
    "gain-rooms": rooms,
    "routes": by_routes,
    "chain": chain,
}
