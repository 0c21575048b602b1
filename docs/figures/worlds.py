"""Contact sheets: generators at three difficulties, and the worlds of suites."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from html import escape

import numpy as np
import shapely

import multisrt as ms
from multisrt import suites

TILE, GAP, LINE = 200, 14, 18
"""Width of a world, distance of worlds and height of a line of text, in pixels."""

DIFFICULTIES = (0.0, 0.5, 1.0)
SIZES_M = {"cavern": 45.0, "warehouse": 45.0, "city": 90.0, "forest": 32.0, "dungeon": 50.0}
SEED = 5

STYLE = """
  svg { background: #fff; font-family: system-ui, sans-serif; }
  rect { fill: #a3a3a3; stroke: none; }
  path { fill: #fff; fill-rule: evenodd; stroke: #303030; stroke-width: 0.7; }
  text { fill: #14212c; font-size: 12px; text-anchor: middle; }
"""


def sheet(title: str, worlds: Sequence[tuple[str, ms.Environment]], columns: int, tile: int) -> str:
    """Draw worlds with a line of text below each."""
    rows = -(-len(worlds) // columns)
    width = columns * (tile + GAP) + GAP
    height = rows * (tile + LINE + GAP) + GAP
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'width="{width}" height="{height}">',
        f"<title>{escape(title)}</title>",
        f"<style>{STYLE}</style>",
    ]
    for place, (text, world) in enumerate(worlds):
        row, column = divmod(place, columns)
        x, y = GAP + column * (tile + GAP), GAP + row * (tile + LINE + GAP)
        parts.append(f'<rect x="{x}" y="{y}" width="{tile}" height="{tile}"/>')
        parts.append(f'<path d="{_path(world, x, y, tile)}"/>')
        parts.append(f'<text x="{x + tile / 2:g}" y="{y + tile + 14}">{escape(text)}</text>')
    return "\n".join([*parts, "</svg>", ""])


def _path(world: ms.Environment, x: float, y: float, tile: float) -> str:
    """Return free space as a path in a square of the sheet, with a margin of 2 pixels."""
    x0, y0, x1, y1 = world.bounds
    scale = (tile - 4) / max(x1 - x0, y1 - y0)
    middle = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
    found = []
    for ring in shapely.get_rings(shapely.get_parts(world.free)):
        points = (shapely.get_coordinates(ring)[:-1] - middle) * [scale, -scale]
        drawn = np.round(points + np.array([x + tile / 2, y + tile / 2]), 1)
        found.append("M" + " ".join(f"{px:g},{py:g}" for px, py in drawn) + "Z")
    return "".join(found)


def generators() -> str:
    """Draw the generators that have a parameter `difficulty`, at three values of it."""
    worlds = [
        (
            f"{name}, {size_m:g} m, difficulty {difficulty:g}",
            ms.environment(name, size_m=size_m, difficulty=difficulty, seed=SEED),
        )
        for name, size_m in SIZES_M.items()
        for difficulty in DIFFICULTIES
    ]
    return sheet("Five generators at three difficulties", worlds, len(DIFFICULTIES), TILE)


def suite(name: str) -> str:
    """Draw all worlds of a suite."""
    worlds = [(world.name.rpartition("/")[2], world) for world in suites.load(name)]
    return sheet(f"The worlds of {name}", worlds, 6, 118)


FIGURES: dict[str, Callable[[], str]] = {
    "generators": generators,
    **{f"suite-{name}": partial(suite, name) for name in suites.names()},
}
