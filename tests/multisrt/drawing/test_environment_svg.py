import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
import shapely

from multisrt.drawing import environment_svg, save_environment_svg
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from tests.multisrt.drawing.pictures import SVG, layers, lines, on_page, paths, texts


def test_the_picture_of_a_world():
    hall = Environment.from_outline(
        "hall", shapely.box(0, 0, 10, 10), [shapely.box(4, 4, 6, 6)], starts=[(1, 2)]
    )
    svg = environment_svg(hall)
    assert texts(svg)[:2] == ["hall", "10 m x 10 m, 96 m² free"]
    assert {"obstacle", "free space", "suggested start"} <= set(texts(svg))
    rings = [shapely.Polygon(ring) for ring in lines(paths(layers(svg)["obstacles"]))]
    assert sorted(ring.area for ring in rings)[:2] == pytest.approx([4.0, 100.0])


def test_worlds_in_parts_say_so():
    parts = shapely.MultiPolygon([shapely.box(0, 0, 1, 1), shapely.box(2, 0, 3, 1)])
    assert texts(environment_svg(Environment("two", parts)))[1].endswith("in 2 separate parts")


def test_save_environment_svg(tmp_path):
    world = environment("cave")
    save_environment_svg(world, tmp_path / "cave.svg")
    assert (tmp_path / "cave.svg").read_text(encoding="utf-8") == environment_svg(world)


@pytest.mark.parametrize(
    "free",
    [
        shapely.box(-500, 2, 500, 3),
        shapely.box(-3, -4000, -2, 4000),
        shapely.box(0, 0, 0.02, 0.01),
        shapely.box(-9e6, -9e6, 9e6, 9e6),
        shapely.box(8_000_000.25, 9_000_000.5, 8_000_020, 9_000_010),
        shapely.MultiPolygon([shapely.box(0, 0, 1, 1), shapely.box(2, 0, 3, 5)]),
    ],
    ids=["wide", "tall", "tiny", "huge", "far", "parts"],
)
def test_worlds_of_any_size_and_place(free):
    x, y = (
        free.geoms[0].centroid.coords[0]
        if free.geom_type == "MultiPolygon"
        else (free.centroid.coords[0])
    )
    world = Environment("odd", free, starts=[(x, y)])
    svg = environment_svg(world)
    x0, y0, x1, y1 = world.bounds
    root, found = ET.fromstring(svg), layers(svg)
    shift = re.findall(r"metres from \((\S+), (\S+)\)", root.findtext(SVG + "desc", ""))
    ox, oy = map(float, shift[0]) if shift else (0.0, 0.0)
    origin = np.array([ox, oy])
    step = max(x1 - x0, y1 - y0) / 5000
    _frame, *rings = lines(paths(found["obstacles"]))
    drawn = [shapely.Polygon(ring + origin) for ring in rings]
    assert len(drawn) == len(world.free.geoms)
    for part, polygon in zip(world.free.geoms, drawn, strict=True):
        np.testing.assert_allclose(polygon.bounds, part.bounds, rtol=0, atol=step)
    place = lines(paths(found["suggested starts"]))[0].mean(axis=0) + origin
    np.testing.assert_allclose(place, (x, y), rtol=0, atol=step)
    left, bottom = on_page(svg, x0 - ox, y0 - oy)
    right, top = on_page(svg, x1 - ox, y1 - oy)
    _, _, width, height = map(float, root.get("viewBox", "").split())
    assert 0 < left < right < width
    assert 0 < top < bottom < height
    assert float(root.get("width", "").removesuffix("mm")) < 300
    assert float(root.get("height", "").removesuffix("mm")) < 300


def test_bundled_worlds_are_drawn(tmp_path: Path):
    for name in ("apartment", "clinic", "workshop"):
        svg = environment_svg(environment(name))
        assert ET.fromstring(svg).tag == SVG + "svg"
        assert len(svg) < 60_000
