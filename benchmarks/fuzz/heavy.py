"""Small files that take long to read, because their overlays, clip paths or macros multiply.

Mutations hardly ever produce such files. Each once took a reader more than `judging.MAX_SECONDS`,
or would without one of its bounds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Final

from benchmarks.fuzz.target import Input, Options

Point = tuple[float, float]

SVG: Final = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">{}</svg>'
ONE_METRE: Final[Options] = {"resolution_m": 1.0}


def star(corners: int) -> list[Point]:
    """Return a ring nearly all of whose edges cross each other, with an odd number of corners."""
    turns = [2 * math.pi * (corners // 2) * k / corners for k in range(corners)]
    return [(round(50 + 50 * math.cos(t), 3), round(50 + 50 * math.sin(t), 3)) for t in turns]


def disc(corners: int) -> list[Point]:
    """Return a ring in the shape of a disc."""
    turns = [2 * math.pi * k / corners for k in range(corners)]
    return [(round(50 + 40 * math.cos(t), 3), round(50 + 40 * math.sin(t), 3)) for t in turns]


def lattice(bars: int) -> list[list[Point]]:
    """Return bars in two directions, which all cross each other."""
    rings: list[list[Point]] = []
    for k in range(bars):
        low, high = round(100 * k / bars, 3), round(100 * k / bars + 30 / bars, 3)
        rings.append([(0, low), (100, low), (100, high), (0, high)])
        rings.append([(low, 0), (high, 0), (high, 100), (low, 100)])
    return rings


def nested(squares: int) -> list[list[Point]]:
    """Return triangles with a common corner, which all overlap."""
    return [[(0, 0), (99, k / 100), (0, 99 - k / 100)] for k in range(squares)]


def wkt(rings: Iterable[list[Point]]) -> str:
    """Return rings as polygons of a collection in well-known text."""
    texts = (", ".join(f"{x:g} {y:g}" for x, y in [*ring, ring[0]]) for ring in rings)
    return f"GEOMETRYCOLLECTION ({', '.join(f'POLYGON (({text}))' for text in texts)})"


def geojson(rings: Iterable[list[Point]]) -> str:
    """Return rings as a multipolygon in GeoJSON."""
    texts = (", ".join(f"[{x:g}, {y:g}]" for x, y in [*ring, ring[0]]) for ring in rings)
    together = ", ".join(f"[[{text}]]" for text in texts)
    return f'{{"type": "MultiPolygon", "coordinates": [{together}]}}'


def imr(border: list[Point], rings: Iterable[list[Point]]) -> str:
    """Return a border and obstacles as an IMR map."""
    texts = ("".join(f"{x:g} {y:g}\n" for x, y in ring) for ring in (border, *rings))
    return "[BORDER]\n" + "[OBSTACLE]\n".join(texts)


def points(ring: Iterable[Point]) -> str:
    """Return points as an attribute of SVG."""
    return " ".join(f"{x:g},{y:g}" for x, y in ring)


def stage_lattice(bars: int) -> str:
    """Return a Stage world with models that cross each other."""
    models = (
        f"model ( size [100 .05 1] pose [50 {100 * k / bars:.3f} 0 0] )\n"
        f"model ( size [.05 100 1] pose [{100 * k / bars:.3f} 50 0 0] )\n"
        for k in range(bars)
    )
    return 'model ( bitmap "rooms.png" size [100 100 1] pose [50 50 0 0] )\n' + "".join(models)


def dxf(*pairs: str) -> str:
    """Return entities, each of them ``code|value|code|value...``, as a drawing."""
    words = "|".join(("0|SECTION|2|ENTITIES", *pairs, "0|ENDSEC|0|EOF")).split("|")
    return "\n".join(words) + "\n"


def dxf_lattice(lines: int, layer: str) -> str:
    """Return a drawing of lines that cross each other."""
    return dxf(
        *(f"0|LINE|8|{layer}|10|0|20|{k}|11|600|21|{k}.5" for k in range(lines)),
        *(f"0|LINE|8|{layer}|10|{k}|20|0|11|{k}.5|21|600" for k in range(lines)),
    )


def clipped(mask: str, content: str) -> str:
    """Return a drawing with a clip path ``c``."""
    return SVG.format(f'<clipPath id="c">{mask}</clipPath>{content}')


def svg_clips(shapes: int, depth: int) -> str:
    """Return shapes in nested groups, each with a clip path of 200 corners."""
    polygon = f'<polygon points="{points(disc(200))}"/>'
    masks = "".join(f'<clipPath id="c{k}">{polygon}</clipPath>' for k in range(depth))
    groups = "".join(f'<g clip-path="url(#c{k})">' for k in range(depth))
    return SVG.format(masks + groups + polygon * shapes + "</g>" * depth)


def yaml(more: str, resolution: str = "0.05") -> str:
    """Return the YAML file of a map with additional content."""
    return (
        f"image: rooms.pgm\nresolution: {resolution}\norigin: [0, 0, 0]\nnegate: 0\n"
        f"occupied_thresh: 0.65\nfree_thresh: 0.196\n{more}"
    )


def merges(levels: int) -> str:
    """Return the YAML file of a map whose aliases multiply by ten with each level."""
    lines = [f"a{k}: &a{k} {{<<: [{', '.join([f'*a{k - 1}'] * 10)}]}}\n" for k in range(1, levels)]
    return yaml("a0: &a0 {k: 1}\n" + "".join(lines))


def macros(levels: int) -> str:
    """Return a Stage world whose macros multiply by eight with each level."""
    lines = [
        f"define m{k} model ( size [1 1 1] {f'm{k - 1} ( pose [1 0 0 1] ) ' * 8})\n"
        for k in range(1, levels)
    ]
    return 'model ( bitmap "rooms.png" size [9 9 1] )\n' + "".join(lines) + f"m{levels - 1} ( )\n"


_TRIANGLE: Final = '<path d="M9 9h82v82z"/>'
_DISC: Final = f'<polygon points="{points(disc(2000))}"/>'
_COMB: Final = "".join(f"M{k / 10:g} 0h.05v99h-.05z" for k in range(900))
_ROWS: Final = "".join(f"M0 {k / 10:g}h99v.05h-99z" for k in range(900))
_REPAIR: Final[Options] = {"repair": True}

HEAVY: Final[dict[str, tuple[str, str, Options, Callable[[], str]]]] = {
    "wkt: one ring, 9,000 times": (
        *("wkt", ".wkt", _REPAIR),
        lambda: f"POLYGON (({'0 0, 5 0, 5 5, 0 5, ' * 9000}0 0))",
    ),
    "wkt: a star": ("wkt", ".wkt", _REPAIR, lambda: wkt([star(4001)])),
    "wkt: a lattice": ("wkt", ".wkt", {}, lambda: wkt(lattice(1000))),
    "wkt: nested polygons": ("wkt", ".wkt", {}, lambda: wkt(nested(5000))),
    "geojson: a star": ("geojson", ".geojson", _REPAIR, lambda: geojson([star(4001)])),
    "geojson: a lattice": ("geojson", ".geojson", {}, lambda: geojson(lattice(1000))),
    "house_expo: one triangle, 700 times": (
        *("house_expo", ".json", {}),
        lambda: f'{{"verts": [[0, 0], {", ".join(["[7, 3], [7, 9], [0, 3]"] * 700)}]}}',
    ),
    "house_expo: a star": (
        *("house_expo", ".json", {}),
        lambda: f'{{"verts": [{", ".join(f"[{x}, {y}]" for x, y in star(4001))}]}}',
    ),
    "imr: a star": ("imr", ".txt", _REPAIR, lambda: imr(star(4001), [])),
    "imr: a lattice": ("imr", ".txt", {}, lambda: imr(disc(9), lattice(1000))),
    "map_server: merges": ("map_server", ".yaml", {}, lambda: merges(9)),
    "map_server: a large integer": (
        *("map_server", ".yaml", {}),
        lambda: yaml("", resolution="0x" + "f" * 50_000),
    ),
    "map_server: a long list": (
        *("map_server", ".yaml", {}),
        lambda: yaml(f"x: [{'1,' * 30_000}1]\n"),
    ),
    "map_server: nesting": ("map_server", ".yaml", {}, lambda: yaml(f"x: {'[' * 60_000}")),
    "stage: a lattice": ("stage", ".world", {}, lambda: stage_lattice(1000)),
    "stage: macros": ("stage", ".world", {}, lambda: macros(9)),
    "dxf: a lattice of walls": (
        *("dxf", ".dxf", ONE_METRE),
        lambda: dxf_lattice(500, "wall"),
    ),
    "dxf: a lattice of obstacles": (
        *("dxf", ".dxf", ONE_METRE),
        lambda: dxf_lattice(500, "obstacle"),
    ),
    "svg: a star": (
        *("svg", ".svg", ONE_METRE),
        lambda: SVG.format(f'<polygon points="{points(star(4001))}"/>'),
    ),
    "svg: a lattice": (
        *("svg", ".svg", ONE_METRE),
        lambda: SVG.format("".join(f'<polygon points="{points(ring)}"/>' for ring in lattice(330))),
    ),
    "svg: clip paths in each other": ("svg", ".svg", ONE_METRE, lambda: svg_clips(3000, 50)),
    "svg: a clip path of many shapes": (
        *("svg", ".svg", ONE_METRE),
        lambda: clipped(_DISC, f'<g clip-path="url(#c)">{_TRIANGLE * 20_000}</g>'),
    ),
    "svg: a clip path that crosses its shapes": (
        *("svg", ".svg", ONE_METRE),
        lambda: clipped(f'<path d="{_COMB}"/>', f'<path clip-path="url(#c)" d="{_ROWS}"/>'),
    ),
    "svg: a clip path in many places": (
        *("svg", ".svg", ONE_METRE),
        lambda: clipped(
            _DISC,
            "".join(
                f'<g transform="translate({k / 1000:g})" clip-path="url(#c)">{_TRIANGLE}</g>'
                for k in range(3000)
            ),
        ),
    ),
    "svg: light and dark discs in turn": (
        *("svg", ".svg", ONE_METRE),
        lambda: SVG.format(
            "".join(
                f'<circle cx="{45 + k / 50:g}" cy="50" r="40" fill="{("#000", "#fff")[k % 2]}"/>'
                for k in range(400)
            )
        ),
    ),
    "svg: a symbol of many commands": (
        *("svg", ".svg", ONE_METRE),
        lambda: SVG.format(
            f'<defs><path id="p" d="{"M0 0" * 100_000}"/></defs>' + '<use href="#p"/>' * 40_000
        ),
    ),
    "svg: a symbol of many transforms": (
        *("svg", ".svg", ONE_METRE),
        lambda: SVG.format(
            f'<defs><rect id="p" width="1" height="1" transform="{"scale(1)" * 20}"/></defs>'
            + '<use href="#p"/>' * 40_000
        ),
    ),
}
"""Format, suffix, options and the function that returns the text of each file, by name."""


def heavy_input(name: str) -> tuple[str, Input]:
    """Return the format and the input of one of `HEAVY`."""
    target, suffix, options, text = HEAVY[name]
    return target, Input(text().encode(), suffix, options)
