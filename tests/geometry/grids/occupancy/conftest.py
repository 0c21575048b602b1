"""What tests of occupancies share: regions by hand and from worlds, and what is known."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import shapely

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.occupancy import FREE, UNKNOWN
from multisrt.geometry.regions.boundary import GAP, OBSTACLE
from multisrt.geometry.regions.safe_region import LocalSafeRegion, local_safe_region
from multisrt.geometry.regions.scan import take_scan

R = 4.0


@pytest.fixture(scope="session")
def seen():
    """The functions of this file."""
    return SimpleNamespace(
        seen_from=seen_from,
        regions_of=regions_of,
        hand_made=hand_made,
        rectangle=rectangle,
        surfaces=surfaces,
        centres=centres,
        in_lattice=in_lattice,
        frontier=frontier,
        knowledge=knowledge,
    )


@pytest.fixture(
    params=[
        ("office", {}),
        ("office", {"beams": 360}),
        ("clutter", {}),
        ("clutter", {"beams": 180}),
        ("crates", {"shape": "star"}),
    ],
    ids=["office", "office-laser", "clutter", "clutter-laser", "crates-star"],
)
def views(request) -> tuple[str, dict[str, Any]]:
    """The name of a world, and how regions are seen in it."""
    name, options = request.param
    return name, options


def seen_from(index, places, *, beams=None, shape="radial", range_m=R):
    """Return the regions that are seen from places."""
    return [
        local_safe_region(take_scan(index, Configuration(x, y), 0.0, range_m, beams), shape)
        for x, y in np.asarray(places).tolist()
    ]


def regions_of(worlds, name, count, *, seed=61, clearance=0.2, **options):
    """Return the regions that are seen from random places of a world."""
    free = worlds.WORLDS[name]()
    places = worlds.viewpoints(free, count, clearance=clearance, seed=seed)
    return seen_from(worlds.index(free), places, **options)


def hand_made(corners, tags):
    """Return a region with given corners and tags."""
    boundary = np.array(corners, float)
    x, y = boundary.mean(axis=0)
    return LocalSafeRegion(x=x, y=y, range_m=R, boundary=boundary, tags=np.array(tags, np.int8))


def rectangle(x0, y0, x1, y1, tag=GAP):
    """Return a region that is a rectangle, with one tag."""
    return hand_made([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], [tag] * 4)


def surfaces(regions):
    """Return the surfaces that regions show, as lines."""
    pieces = [
        np.stack([r.boundary, np.roll(r.boundary, -1, axis=0)], axis=1)[r.tags == OBSTACLE]
        for r in regions
    ]
    return shapely.linestrings(np.concatenate(pieces))


def centres(occupancy):
    """Return the centres of all cells of the window."""
    rows, columns = np.indices(occupancy.cells.shape)
    cells = np.column_stack([rows.ravel(), columns.ravel()])
    return occupancy.centres_of(in_lattice(occupancy, cells))


def in_lattice(raster, index):
    """Return indices of the arrays as rows and columns of the lattice."""
    return index + np.array([raster.row, raster.column])


def frontier(occupancy):
    """Return which cells are frontier, by definition."""
    known = np.pad(occupancy.cells, 1) != UNKNOWN
    inside = known[:-2, 1:-1] & known[2:, 1:-1] & known[1:-1, :-2] & known[1:-1, 2:]
    return (occupancy.cells == FREE) & ~inside


def knowledge(occupancy):
    """Return all that is known, whatever the window: known cells, and groups with targets."""
    known = np.argwhere(occupancy.cells != UNKNOWN)
    named = in_lattice(occupancy, known)
    return (
        named.tolist(),
        occupancy.cells[*known.T].tolist(),
        occupancy.passable[*known.T].tolist(),
        [(g.cells.tolist(), g.target, g.size_m) for g in occupancy.frontier_groups(0.0)],
    )
