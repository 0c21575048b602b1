import contextlib
import math
import re
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image, ImageDraw
from shapely import Polygon

from multisrt.drawing import save_environment_svg
from multisrt.environments import Environment, environment
from multisrt.environments.formats import format_of, read_environment, regions
from multisrt.environments.formats.files import MAX_STARTS
from multisrt.environments.formats.regions import Pen, filled, stroked, union_of
from multisrt.environments.formats.svg.lengths import matrix
from multisrt.environments.formats.svg.path_data import subpaths
from multisrt.geometry.errors import MapFormatError

XMLNS = 'xmlns="http://www.w3.org/2000/svg"'
BLACK = 'fill="none" stroke="black"'


def read(tmp_path, text, resolution_m=1.0, **options):
    path = tmp_path / "plan.svg"
    path.write_text(text)
    return read_environment(path, resolution_m=resolution_m, **options)


def page(content, box="0 0 10 8", more=""):
    return f'<svg {XMLNS} viewBox="{box}" {more}>{content}</svg>'


def wall_area(tmp_path, content, **options):
    """The area of the page of 10 x 8 that is not free; a unit is large, and curves are round."""
    return 80 - read(tmp_path, page(content), resolution_m=30.0, **options).area_m2 / 900


# Plans as programs and people write them.

INKSCAPE = """<?xml version="1.0" encoding="UTF-8" standalone="no"?>
<!-- Created with Inkscape (http://www.inkscape.org/) -->
<svg width="297mm" height="210mm" viewBox="0 0 297 210" version="1.1" id="svg8"
   inkscape:version="1.3.2 (091e20e, 2023-11-25)" sodipodi:docname="plan.svg"
   xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"
   xmlns:sodipodi="http://sodipodi.sourceforge.net/DTD/sodipodi-0.dtd"
   xmlns="http://www.w3.org/2000/svg" xmlns:svg="http://www.w3.org/2000/svg">
  <sodipodi:namedview id="namedview7" pagecolor="#ffffff" inkscape:document-units="mm"/>
  <defs id="defs2"><rect id="unused" width="999" height="999"/></defs>
  <g inkscape:label="Scan" inkscape:groupmode="layer" id="layer4" style="display:none">
    <image width="100" height="100" href="scan.png"/>
  </g>
  <g inkscape:groupmode="layer" id="layer2" inkscape:label="Outline" style="display:inline">
    <rect style="fill:none;stroke:#808080;stroke-width:0.25" id="rect9"
       width="200" height="100" x="20" y="30"/>
  </g>
  <g inkscape:label="Walls" inkscape:groupmode="layer" id="layer1" transform="translate(20,30)">
    <path style="fill:none;stroke:#000000;stroke-width:2;stroke-linecap:butt" id="path10"
       d="M 100,0 V 40 M 100,60 v 40"/>
    <path style="fill:none;stroke:#000000;stroke-width:2" id="path11" d="m 0,50 h 99"/>
  </g>
  <g inkscape:groupmode="layer" id="layer3" inkscape:label="Doors">
    <path style="fill:none;stroke:#e53935;stroke-width:2" d="m 60,80 h 10"/>
  </g>
  <g inkscape:groupmode="layer" id="layer5" inkscape:label="Furniture">
    <circle style="fill:#aaccee;stroke:none" cx="180" cy="60" r="10"/>
  </g>
  <g inkscape:groupmode="layer" id="layer6" inkscape:label="Robot starts">
    <circle cx="30" cy="40" r="2"/><circle cx="200" cy="120" r="2"/>
  </g>
  <g inkscape:groupmode="layer" id="layer7" inkscape:label="Labels">
    <text x="50" y="50">Kitchen</text><rect x="0" y="0" width="297" height="30" fill="black"/>
  </g>
</svg>
"""


def test_a_plan_of_inkscape_by_its_layers(tmp_path):
    world = read(tmp_path, INKSCAPE, resolution_m=0.1)
    walls = 8 * 0.2 + 9.9 * 0.2 - 1.0 * 0.2
    assert world.area_m2 == pytest.approx(20 * 10 - walls - math.pi, abs=0.03)
    assert world.bounds == pytest.approx((2, 8, 22, 18))
    # The page is 21 m high.
    assert world.starts == (pytest.approx((3, 17)), pytest.approx((20, 9)))
    assert len(world.components) == 1
    assert world.origin == "plan.svg at 0.1 m per user unit, walls by their names"


def test_paper_asks_for_its_scale_and_says_what_it_would_be(tmp_path):
    with pytest.raises(MapFormatError) as caught:
        read(tmp_path, INKSCAPE, resolution_m=None)
    assert "page of 297 x 210 mm, which is paper" in str(caught.value)
    assert "A user unit is 1 mm on paper: 0.001 at full size, 0.1 at 1:100" in str(caught.value)


BY_HAND = """<svg xmlns="http://www.w3.org/2000/svg" width="800" height="600">
  <style>
    /* walls */
    .wall, line.wall { stroke: #222; stroke-width: 10px; fill: none }
    #tree { fill: darkgreen }
    @media print { .wall { stroke: none } }
    text { font-size: 12px }
  </style>
  <rect width="100%" height="100%" fill="#fafafa"/>
  <g class="floor" transform="translate(50 50)">
    <rect class="wall" width="700" height="500"/>
    <line class="wall" x1="300" y1="0" x2="300" y2="400"/>
    <circle id="tree" cx="500" cy="250" r="50"/>
    <text x="100" y="100">Kitchen</text>
  </g>
</svg>"""


def test_a_plan_by_hand_with_classes(tmp_path):
    world = read(tmp_path, BY_HAND, resolution_m=0.01)
    # The class "wall" names the walls; the tree has no name, so that it does not count.
    frame = 8 * 6 - (7.1 * 5.1 - 6.9 * 4.9) - 0.1 * 3.95
    assert world.area_m2 == pytest.approx(frame)
    inside = world.component(1.0, 1.0)
    assert inside.area == pytest.approx(6.9 * 4.9 - 0.1 * 3.95)
    assert world.contains(5.5, 3.0)


def test_the_same_plan_by_lightness(tmp_path):
    text = BY_HAND.replace("wall", "w").replace(">Kitchen<", ">K<")
    world = read(tmp_path, text, resolution_m=0.01)
    assert not world.contains(5.5, 3.0)
    walls = (7.1 * 5.1 - 6.9 * 4.9) + 0.1 * 3.95
    assert world.area_m2 == pytest.approx(8 * 6 - walls - math.pi / 4, abs=0.01)
    assert world.origin.endswith("at 0.01 m per user unit, free above lightness 0.5")


CUBICASA = f"""<svg {XMLNS} width="1000" height="600" viewBox="0 0 1000 600">
<g id="Model"><g class="Floor"><g class="Floorplan Floor-1">
  <g class="Space Kitchen"><polygon points="20,20 490,20 490,580 20,580" fill="#d5d5d5"/></g>
  <g id="Wall" class="Wall External" fill="#000000" stroke="#000000" style="stroke-width: 1">
    <polygon points="0,0 1000,0 1000,20 0,20 "/>
    <g id="Window" class="Window Regular"><polygon points="100,0 200,0 200,20 100,20 "/></g>
  </g>
  <g class="Wall External"><polygon points="0,580 1000,580 1000,600 0,600" stroke="none"/></g>
  <g class="Wall External"><polygon points="0,0 20,0 20,600 0,600" stroke="none"/></g>
  <g class="Wall External"><polygon points="980,0 1000,0 1000,600 980,600" stroke="none"/></g>
  <g class="Wall" stroke="none"><polygon points="490,0 510,0 510,600 490,600"/>
    <g class="Door Swing Beside"><polygon points="490,100 510,100 510,200 490,200" fill="#fff"/>
      <g class="Panel Area"><path d="M510,100 q 100,0 100,100" fill="none" stroke="#000"/></g>
    </g>
  </g>
  <g class="FixedFurniture BaseCabinet"><g class="BoundaryPolygon">
    <polygon points="20,20 120,20 120,80 20,80" style="fill:none"/></g></g>
</g></g></g></svg>"""


def test_a_plan_with_rooms_and_doors_in_walls(tmp_path):
    world = read(tmp_path, CUBICASA, resolution_m=0.01)
    rooms = 4.7 * 5.6 * 2 + 0.2 * 1.0 - 1.0 * 0.6
    assert world.area_m2 == pytest.approx(rooms, abs=0.06)  # a stroke of 1 cm on one wall
    assert len(world.components) == 1


# What shapes paint.


@pytest.mark.parametrize(
    ("content", "area"),
    [
        ('<rect x="1" y="1" width="2" height="3"/>', 6),
        ('<rect x="1" y="1" width="2" height="3" rx="1"/>', 2 + math.pi),
        ('<rect x="1" y="1" width="2" height="4" rx="5" ry="1"/>', 4 + math.pi),
        ('<rect x="10%" y="10%" width="20%" height="50%"/>', 8),
        ('<circle cx="5" cy="4" r="2"/>', 4 * math.pi),
        ('<ellipse cx="5" cy="4" rx="2" ry="1"/>', 2 * math.pi),
        ('<polygon points="1,1 4,1 4,3"/>', 3),
        ('<polyline points="1,1 4,1 4,3"/>', 3),
        (f'<polyline points="1,1 4,1 4,3" {BLACK} stroke-width=".2"/>', 1.0),
        (f'<polyline points="1,1 4,1 4,3" {BLACK} stroke-width=".2" stroke-linecap="square"/>',
         1.04),
        (f'<polyline points="1,1 4,1 4,3" {BLACK} stroke-linejoin="bevel" stroke-width=".2"/>',
         0.995),
        (f'<line x1="1" y1="1" x2="4" y2="5" {BLACK} stroke-width="2"/>', 10),
        (f'<line x1="3" y1="4" x2="6" y2="4" {BLACK} stroke-width="2" stroke-linecap="round"/>',
         6 + math.pi),
        (f'<path d="M3 4h0" {BLACK} stroke-width="2" stroke-linecap="round"/>', math.pi),
        (f'<rect x="1" y="1" width="4" height="3" {BLACK} stroke-width=".5"/>', 7),
        (f'<rect x="1" y="1" width="4" height="3" {BLACK} stroke-width=".5" '
         'stroke-linejoin="round"/>', 7 - 0.25 + math.pi / 16),
        (f'<polygon points="1,1 5,1 5,4 1,4" {BLACK} stroke-width=".5"/>', 7),
        (f'<path d="M1 1h4v3h-4z" {BLACK} stroke-width=".5"/>', 7),
        (f'<path d="M1 1h4v3h-4V1" {BLACK} stroke-width=".5"/>', 7),
        ('<path d="M1 1 h4 v3 h-4 z M2 2 h1 v1 h-1 z" fill-rule="evenodd"/>', 11),
        ('<path d="M1 1 h4 v3 h-4 z M2 2 h1 v1 h-1 z"/>', 12),
        ('<path d="M1 1 h4 v3 h-4 z M2 2 v1 h1 v-1 z"/>', 11),
        ('<path d="M1 1 L5 5 L5 1 L1 5z"/>', 8),
        ('<path d="M3 2 A2 2 0 0 1 3 6 A2 2 0 0 1 3 2"/>', 4 * math.pi),
        ('<path d="M3 2 a2 2 0 013 0z"/>', 4 * math.asin(0.75) - 1.5 * math.sqrt(1.75)),
        ('<path d="M1 5 Q3 1 5 5z"/>', 16 / 3),
        ('<path d="M1 5 C1 1 5 1 5 5z"/>', 9.6),
        ('<path d="m1 1 2 0 0 2zm4 0 2 0 0 2"/>', 4),
        # Only what is given, and how.
        ('<rect width="2" height="2" fill="#808080"/><rect width="1" height="1" fill="#444"/>', 1),
        ('<rect width="2" height="2" style="fill:#888"/><rect width="1" height="1"/>', 1),
        ('<g fill="white"><rect width="2" height="2"/><rect fill="rgb(9,9,9)" width="1" '
         'height="1"/></g>', 1),
        ('<rect width="2" height="2" fill-opacity=".4"/><rect width="1" height="1"/>', 1),
        ('<rect width="2" height="2" opacity="60%"/>', 4),
        ('<g opacity=".7"><rect width="2" height="2" opacity=".7"/></g>'
         '<rect width="1" height="1"/>', 1),
        ('<rect width="2" height="2" fill="rgba(0,0,0,0.3)"/><rect width="1" height="1"/>', 1),
        ('<rect width="2" height="2"/><rect width="1" height="1" fill="#fff"/>', 3),
        ('<rect width="2" height="2"/><rect width="1" height="1" fill="#fff" opacity=".3"/>', 4),
        ('<rect width="1" height="1" fill="#fff"/><rect width="2" height="2"/>', 4),
        (f'<path d="M0 4h5" {BLACK} stroke-dasharray="1,1"/><rect width="1" height="1"/>', 1),
        ('<rect width="2" height="2" display="none"/><rect width="1" height="1"/>', 1),
        ('<g style="display : none"><rect width="2" height="2"/></g><rect width="1" height="1"/>',
         1),
        ('<g visibility="hidden"><rect width="2" height="2"/>'
         '<rect width="1" height="1" visibility="visible"/></g>', 1),
        ('<g color="black"><rect width="1" height="1" fill="currentColor"/></g>', 1),
        ('<text>Hall</text><rect width="1" height="1"/>', 1),
        # Transforms, references, views.
        ('<g transform="translate(2,1)"><g transform="scale(2)"><rect width="1" height="1"/></g>'
         '</g>', 4),
        ('<rect width="2" height="1" transform="rotate(30 1 1) translate(3 3)"/>', 2),
        ('<rect width="2" height="1" transform="translate(3) skewX(40)"/>', 2),
        ('<rect width="2" height="1" transform="matrix(0 1 -1 0 5 1)"/>', 2),
        (f'<g transform="scale(2 1)"><path d="M2 1v3" {BLACK} stroke-width=".5"/></g>', 3),
        (f'<g transform="scale(2)"><path d="M2 1v3" {BLACK} stroke-width=".5" '
         'vector-effect="non-scaling-stroke"/></g>', 3),
        ('<defs><g id="t"><rect width="1" height="1"/></g></defs><use href="#t"/>'
         '<use xlink:href="#t" xmlns:xlink="http://www.w3.org/1999/xlink" x="3" y="2" '
         'transform="scale(2)"/>', 5),
        ('<symbol id="s" viewBox="0 0 10 10"><rect width="10" height="5"/></symbol>'
         '<use href="#s" width="2" height="2"/>', 2),
        ('<symbol id="s"><rect width="2" height="2"/></symbol><use href="#s" fill="#999"/>'
         '<rect x="5" width="1" height="1"/>', 1),
        ('<svg x="1" y="1" width="4" height="4" viewBox="0 0 1 1"><rect width="1" height=".5"/>'
         '</svg>', 8),
        ('<clipPath id="c"><rect width="1" height="9"/></clipPath>'
         '<g clip-path="url(#c)"><rect width="3" height="3"/></g>', 3),
        ('<clipPath id="c"><circle r="1"/></clipPath>'
         '<rect transform="scale(2)" clip-path="url(#c)" width="3" height="3"/>', math.pi),
        # Style sheets.
        ('<style>.a{fill:none}.b{fill:black}</style><rect class="a" width="2" height="2"/>'
         '<rect class="b a" width="1" height="1"/>', 1),
        ('<style>rect{fill:white}#x{fill:black}rect.y{fill:white}</style>'
         '<rect id="x" class="y" width="1" height="1"/>', 1),
        ('<style>*{fill:white !important}</style><rect style="fill:black" width="2" height="2"/>'
         '<rect style="fill:black!important" width="1" height="1"/>', 1),
        ('<style>@font-face{font-family:x} @import "y.css"; a:hover{fill:none} /* } */</style>'
         '<rect width="1" height="1"/>', 1),
    ],
)  # fmt: skip
def test_painted_areas_are_walls(tmp_path, content, area):
    assert wall_area(tmp_path, content) == pytest.approx(area, rel=5e-4, abs=1e-9)


def test_curves_are_within_five_millimetres_at_every_scale(tmp_path):
    for scale in (0.01, 1.0, 30.0):
        content = f'<circle cx="5" cy="4" r="3" transform="scale({scale})"/>'
        box = f"0 0 {10 * scale} {8 * scale}"
        world = read(tmp_path, page(content, box), resolution_m=2.0)
        (hole,) = world.components[0].interiors
        points = np.asarray(hole.coords) - (10 * scale, 8 * scale)
        middles = (points[1:] + points[:-1]) / 2
        radius = 6 * scale
        assert np.hypot(*points.T) == pytest.approx(radius)
        sagitta = radius - np.hypot(*middles.T)
        assert sagitta.max() <= 0.005 * 1.0001 or len(points) == 7
        assert sagitta.max() > 0.003 or len(points) == 7


# Lengths and scales.


@pytest.mark.parametrize(
    ("size", "box", "area"),
    [
        ('width="5000mm" height="4000mm"', 'viewBox="0 0 500 400"', 20),
        ('width="500cm" height="400cm"', 'viewBox="0 0 5 4"', 20),
        ('width="100in" height="50in"', 'viewBox="0 0 10 5"', 5000 * 0.0254**2),
        ('width="500cm"', 'viewBox="0 0 5 4"', 20),
        ('width="500cm" height="600cm"', 'viewBox="0 0 5 4"', 30),
        ('width="500cm" height="400cm"', "", 20),
    ],
)
def test_a_page_that_is_no_paper_has_its_own_size(tmp_path, size, box, area):
    text = f'<svg {XMLNS} {size} {box}><rect width="10%" height="10%"/></svg>'
    path = tmp_path / "plan.svg"
    path.write_text(text)
    world = read_environment(path)
    page_area = world.area_m2 + shapely.box(*world.bounds).difference(world.free).area
    assert page_area == pytest.approx(area)
    assert world.origin == "plan.svg at its own size, free above lightness 0.5"


def test_a_resolution_counts_more_than_a_size(tmp_path):
    text = page('<rect width="1" height="1"/>', more='width="5000mm" height="4000mm"')
    assert read(tmp_path, text, resolution_m=2.0).area_m2 == pytest.approx(79 * 4)


def test_lower_left_corner_of_the_page_is_the_origin(tmp_path):
    world = read(tmp_path, page('<rect x="-5" y="-3" width="4" height="2"/>', "-5 -3 10 8"))
    assert world.free.equals(shapely.box(0, 0, 10, 8) - shapely.box(0, 6, 4, 8))


def test_without_a_page_the_box_around_the_walls_is_it(tmp_path):
    text = f'<svg {XMLNS}><path d="M20 30h4v3h-4z" {BLACK} stroke-width=".5"/></svg>'
    assert read(tmp_path, text).free.equals(shapely.box(0.5, 0.5, 4, 3))


@pytest.mark.parametrize("more", ["", 'width="400" height="300"', 'width="100%"'])
def test_scale_is_asked_for(tmp_path, more):
    with pytest.raises(MapFormatError, match=r"plan\.svg does not say how large a user unit is"):
        read(tmp_path, page('<rect width="1" height="1"/>', more=more), resolution_m=None)


# Names.


def test_names_of_nearer_groups_count(tmp_path):
    text = page(
        '<g id="walls"><g id="layer2"><rect width="2" height="2"/></g>'
        '<g class="door"><rect width="1" height="1"/></g></g><rect width="9" height="7"/>'
    )
    assert read(tmp_path, text).area_m2 == pytest.approx(77, abs=0.002)


def test_obstacles_are_areas_and_walls_are_painted_areas(tmp_path):
    rect = f'<rect x="1" y="1" width="4" height="4" {BLACK} stroke-width="1"/>'
    assert wall_area(tmp_path, f'<g class="wall">{rect}</g>') == pytest.approx(16)
    assert wall_area(tmp_path, f'<g class="obstacles">{rect}</g>') == pytest.approx(16)
    solid = rect.replace("none", "white")
    assert wall_area(tmp_path, f'<g class="wall">{solid}</g>') == pytest.approx(25)
    line = f'<path class="obstacle" d="M1 1h4" {BLACK} stroke-width=".5"/>'
    assert wall_area(tmp_path, line) == pytest.approx(2)


@pytest.mark.parametrize("names", ["{0}wall{1} {0}door{1}", "{0}w{1} {0}d{1}"])
@pytest.mark.parametrize("degrees", [0, 17, 30, 45, 71])
def test_doors_that_end_where_walls_do_are_open(tmp_path, names, degrees):
    wall, door = names.format('class="', '"').split()
    turned = f'transform="translate(5.1 4.3) rotate({degrees})"'
    text = page(
        f'<g {turned}><path {wall} d="M-3 0H3" {BLACK} stroke-width=".3"/></g>'
        f'<path {door} d="M-.3 .1h.7" {turned} fill="none" stroke="white" stroke-width=".3"/>'
        f'<path {door} d="M-.3 0h.7" {turned} fill="none" stroke="white" stroke-width=".3"/>',
        "0 0 10 8",
    )
    for resolution_m in (1.0, 0.1, 0.37):
        world = read(tmp_path, text, resolution_m=resolution_m)
        assert len(world.components) == 1
        turn = math.radians(degrees)
        across = shapely.LineString(
            [
                (-0.5 * math.sin(turn), -0.5 * math.cos(turn)),
                (0.5 * math.sin(turn), 0.5 * math.cos(turn)),
            ]
        )
        middle = shapely.affinity.translate(across, 5.1, 8 - 4.3)
        scaled = shapely.affinity.scale(middle, resolution_m, resolution_m, origin=(0, 0))
        assert world.free.contains(scaled)


def test_the_outline_of_an_obstacle_is_not_free(tmp_path):
    table = '<g class="furniture"><path class="outline" d="M1 1h2v2h-2z" fill="none"/></g>'
    assert wall_area(tmp_path, table) == pytest.approx(4)


def test_free_space_by_name_replaces_the_page(tmp_path):
    text = page(
        f'<path id="outline" d="M1 1h8v6h-8z" {BLACK}/><rect class="free" width="1" height="1"/>'
        '<circle class="start" cx="3" cy="3" r=".5"/><path class="starts" d="M1 2h2v2zM5 5h1v1"/>'
    )
    world = read(tmp_path, text)
    assert world.free.equals(shapely.box(1, 1, 9, 7) | shapely.box(0, 7, 1, 8))
    assert world.starts == (pytest.approx((3, 5)), pytest.approx((2, 5)), pytest.approx((5.5, 2.5)))


def test_dashed_walls_with_a_name_are_walls(tmp_path):
    line = f'<path class="wall" d="M1 1h4" {BLACK} stroke-width=".5" stroke-dasharray="1"/>'
    assert wall_area(tmp_path, line) == pytest.approx(2)


def test_threshold_is_a_lightness(tmp_path):
    grey = '<rect width="2" height="2" fill="#cccccc"/><rect width="1" height="1"/>'
    assert wall_area(tmp_path, grey) == pytest.approx(1)
    assert wall_area(tmp_path, grey, threshold=0.9) == pytest.approx(4)
    with pytest.raises(MapFormatError, match=r"layers by name, .*leave out --threshold.*wall \("):
        wall_area(tmp_path, '<rect id="wall" width="1" height="1"/>', threshold=0.5)
    with pytest.raises(MapFormatError, match="threshold is 2"):
        wall_area(tmp_path, grey, threshold=2)


# Our own pictures, and other oracles.


@pytest.mark.parametrize("name", ["apartment", "office", "cave", "clutter"])
def test_pictures_of_this_package_are_read_back(tmp_path, name):
    world = environment(name)
    path = tmp_path / f"{name}.svg"
    save_environment_svg(world, path)
    again = read_environment(path)
    assert again.name == name
    assert shapely.hausdorff_distance(again.free.boundary, world.free.boundary) < 1e-3
    assert len(again.edges) == len(world.edges)
    np.testing.assert_allclose(again.starts, world.starts, atol=1e-3)
    with pytest.raises(MapFormatError, match="has its own scale"):
        read_environment(path, resolution_m=1.0)


def test_pictures_far_from_the_origin_are_read_back(tmp_path):
    world = Environment("far", shapely.box(70_000, -90_000, 70_010, -89_995))
    path = tmp_path / "far.svg"
    save_environment_svg(world, path)
    assert read_environment(path).bounds == pytest.approx(world.bounds, abs=1e-3)


coordinates = st.integers(0, 20).map(lambda k: k / 2)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(
    shapes=st.lists(
        st.tuples(st.lists(st.tuples(coordinates, coordinates), min_size=3, max_size=5),
                  st.booleans()),
        min_size=1, max_size=8,
    ).filter(lambda shapes: any(dark for _, dark in shapes)),
)  # fmt: skip
def test_the_topmost_paint_decides(tmp_path_factory, shapes):
    """The topmost paint decides, as in a raster image of the same shapes."""
    content, scale = "", 8
    image = Image.new("L", (10 * scale, 10 * scale), 255)
    for points, dark in shapes:
        triangle = points[:3]
        content += (
            f'<polygon points="{" ".join(f"{x},{y}" for x, y in triangle)}" '
            f'fill="{"black" if dark else "white"}"/>'
        )
        corners = [(x * scale, y * scale) for x, y in triangle]
        ImageDraw.Draw(image).polygon(corners, fill=0 if dark else 255)
    path = tmp_path_factory.getbasetemp() / "paint.svg"
    path.write_text(page(content, "0 0 10 10"))
    try:
        free = read_environment(path, resolution_m=1.0).free
    except MapFormatError as error:
        assert "no walls" in str(error) or "cover everything" in str(error)  # noqa: PT017
        return
    seen = np.asarray(image)[::-1] > 0
    rows, columns = np.mgrid[: 10 * scale, : 10 * scale]
    x, y = (columns + 0.5) / scale, (rows + 0.5) / scale
    edges = shapely.union_all(
        [shapely.LineString([*points[:3], points[0]]) for points, _ in shapes]
    )
    clear = shapely.distance(edges, shapely.points(x, 10 - y)) > 1.5 / scale
    assert (shapely.contains_xy(free, x, y) == seen)[clear].all()


@settings(max_examples=60, deadline=None)
@given(
    rings=st.lists(
        st.lists(st.tuples(coordinates, coordinates), min_size=3, max_size=7), max_size=3
    ),
    rule=st.sampled_from(["nonzero", "evenodd"]),
)
def test_fill_rules_count_how_often_rings_wind(rings, rule):
    arrays = [np.array(ring) for ring in rings]
    area = filled(Path("plan.svg"), arrays, rule)
    assert area.is_valid
    points = np.random.default_rng(0).uniform(0, 10, (200, 2))
    winding = np.zeros(len(points))
    for ring in arrays:
        ahead = ring[np.newaxis] - points[:, np.newaxis]
        angle = np.arctan2(*np.moveaxis(ahead, 2, 0)[::-1])
        turn = (np.roll(angle, -1, axis=1) - angle + np.pi) % (2 * np.pi) - np.pi
        winding += np.rint(turn.sum(axis=1) / (2 * np.pi))
    inside = winding % 2 == 1 if rule == "evenodd" else winding != 0
    assert (shapely.contains_xy(area, *points.T) == inside).all()


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        ("M1 2 3 4", [[1, 2], [3, 4]]),
        ("m1-2.5.5.5", [[1, -2.5], [1.5, -2]]),
        ("M1,2H5V6h-1v-1", [[1, 2], [5, 2], [5, 6], [4, 6], [4, 5]]),
        ("M0 0L1e1-1E-1", [[0, 0], [10, -0.1]]),
        ("M0 0zl1 1", [[0, 0], [1, 1]]),
        ("M1 1a1 1 0 0110 10", [[1, 1], [11, 11]]),
        ("M1 1A0 5 0 0 1 4 4", [[1, 1], [4, 4]]),
    ],
)
def test_path_data_are_parsed(data, expected):
    last = subpaths(data, 100.0)[-1].points
    assert last[[0, -1]].tolist() == [expected[0], expected[-1]]
    if not set(data) & set("aA"):
        assert last.tolist() == expected


@pytest.mark.parametrize(
    ("smooth", "full"),
    [
        ("M0 0C1 2 3 4 5 6S7 8 9 9", "M0 0C1 2 3 4 5 6C7 8 7 8 9 9"),
        ("M0 0S3 4 5 6", "M0 0C0 0 3 4 5 6"),
        ("M0 0Q1 2 4 4t2 5T9 9", "M0 0Q1 2 4 4Q7 6 6 9Q5 12 9 9"),
        ("M0 0C1 2 3 4 5 6T9 9", "M0 0C1 2 3 4 5 6Q5 6 9 9"),
        ("M1 1c1 2 3 4 5 6s2 2 3 3q1 1 2 0", "M1 1C2 3 4 5 6 7C8 9 8 9 9 10Q10 11 11 10"),
    ],
)
def test_smooth_curves_continue(smooth, full):
    (one,), (two,) = subpaths(smooth, 1e-3), subpaths(full, 1e-3)
    np.testing.assert_allclose(one.points, two.points, atol=1e-9)


@pytest.mark.parametrize("cap", ["flat", "round", "square"])
@pytest.mark.parametrize("join", ["mitre", "round", "bevel"])
@pytest.mark.parametrize("closed", [False, True])
def test_long_strokes_are_as_in_one_piece(monkeypatch, cap, join, closed):
    turn = np.linspace(0, 5.8, 240)
    waves = (4 + 0.3 * np.sin(9 * turn)) * [np.cos(turn), np.sin(turn)]
    whole = stroked(waves.T, closed, 0.2, Pen(cap, join))
    monkeypatch.setattr(regions, "PIECE_POINTS", 1000)
    one = stroked(waves.T, closed, 0.2, Pen(cap, join))
    assert whole.symmetric_difference(one).area < 1e-3 * one.area


def test_transforms_are_applied_from_the_right():
    turned = matrix("translate(10,0) rotate(90) scale(2 3)") @ (1, 1, 1)
    np.testing.assert_allclose(turned, (7, 2, 1))
    np.testing.assert_allclose(matrix("rotate(90,1,1)") @ (2, 1, 1), (1, 2, 1), atol=1e-12)


# What is wrong.


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("<rect", "line 1 is not well-formed XML"),
        ('<rect width="1"/>', "no walls"),
        ("<text>hi</text>", "no walls"),
        ('<rect width="1" height="1" fill="#fff"/>', "no walls: .*darker than 0.5.*wall, obstacle"),
        ('<rect width="10" height="8"/>', "walls cover everything"),
        ('<rect width="12" height="8"/>', "17% of the walls are outside the page"),
        ('<rect width="one" height="1"/>', "<rect>: 'one' is not a length"),
        ('<rect width="1em" height="1"/>', "'1em' is not a length"),
        ('<rect width="-1" height="1"/>', "negative"),
        ('<circle r="-1"/>', "negative"),
        ('<path d="1 1"/>', "no command before"),
        ('<path d="L1 1"/>', "begin with 'L'"),
        ('<path d="M1 1X"/>', "'X' is not a command"),
        ('<path d="M1"/>', "where M needs a number"),
        ('<path d="M1 1z2 2"/>', "no command before"),
        ('<path d="M1 1a1 1 0 2 0 1 1"/>', "flag 0 or 1"),
        ('<path d="M1 1L1e13 1"/>', "not a number up to"),
        ('<polygon points="1 1 2"/>', "one is alone"),
        ('<polygon points="1 1 2 x"/>', "'x' is not part of a list of"),
        ('<rect width="1e9" height="1"/>', "further than 1e"),
        ('<rect width="1" height="1" transform="turn(1)"/>', "turn with 1 numbers"),
        ('<rect width="1" height="1" transform="scale(1,2,3)"/>', "scale with 3 numbers"),
        ('<rect width="1" height="1" transform="scale(1) x"/>', "not a transform"),
        ('<g transform="scale(1e9)"><g transform="scale(1e9)"><rect/></g></g>', "beyond 1e"),
        ('<rect width="1" height="1" fill="url(#p)"/>', r"paint 'url\(#p\)' is not a plain colour"),
        ('<rect width="1" height="1" fill="no"/>', "not a plain colour"),
        ('<rect width="1" height="1" fill-rule="odd"/>', "fill-rule is 'odd'"),
        ('<rect width="1" height="1" opacity="x"/>', "'x' is not a number"),
        (f'<path d="M0 0h1" {BLACK} stroke-linecap="long"/>', "cap or join 'long'"),
        (f'<path d="M0 0h1" {BLACK} stroke-width="-1"/>', "stroke-width is -1"),
        ('<image href="scan.png"/>', "images are not read"),
        ('<use href="other.svg#a"/>', "'other.svg#a' is in another file"),
        ('<use href="http://example.org/a.svg#b"/>', "is in another file"),
        ('<use href="#a"/>', "there is no '#a'"),
        ('<g id="a"><use href="#a"/></g>', "nested more than 100 deep"),
        ('<g mask="url(#m)"><rect width="1" height="1"/></g>', "masks are not read"),
        ('<rect id="a" width="1" height="1" clip-path="url(#a)"/>', "not a clipPath"),
        ("<style>g rect{fill:none}</style>", "style rule for 'g rect'"),
        ("<style>rect{transform:scale(2)}</style>", "transform in a style"),
        ('<rect class="wall" width="1" height="1" fill="none"/>', "give them a stroke or a fill"),
        ('<path class="free" d="M1 1h5"/>', "draw a closed outline"),
        ('<rect class="free" width="1" height="1"/><rect id="wall" width="1" height="1"/>',
         "cover everything"),
        ('<rect class="start" x="1" y="1" width="2" height="2"/><rect width="5" height="5"/>',
         r"suggested start \(2, 6\) is not in free space"),
    ],
)  # fmt: skip
def test_faults_are_named(tmp_path, content, message):
    with pytest.raises(MapFormatError, match=rf"plan\.svg.*{message}"):
        read(tmp_path, page(content))


@pytest.mark.parametrize("box", ["0 0 10", "0 0 0 8", "0 0 -1 8", "a b c d", "0 0 nan 8"])
def test_a_wrong_view_box_is_named(tmp_path, box):
    with pytest.raises(MapFormatError, match="line 1, <svg>"):
        read(tmp_path, page('<rect width="1" height="1"/>', box))


LOL = "".join(f'<!ENTITY lol{k} "{f"&lol{k - 1};" * 10 if k else "lol"}">' for k in range(10))


@pytest.mark.parametrize(
    ("document_type", "message"),
    [
        (f"<!DOCTYPE svg [{LOL}]>", "declarations in its document type"),
        ('<!DOCTYPE svg [<!ENTITY x SYSTEM "file:///etc/passwd">]>', "declarations"),
        ('<!DOCTYPE svg [<!ATTLIST rect fill CDATA "black">]>', "declarations"),
        ('<!DOCTYPE svg [<!ENTITY % x SYSTEM "x.dtd">%x;]>', "declarations"),
    ],
)
def test_declarations_are_refused(tmp_path, document_type, message):
    text = document_type + page('<text>&lol9;</text><rect width="1" height="1"/>')
    with pytest.raises(MapFormatError, match=message):
        read(tmp_path, text)


def test_a_document_type_by_name_is_not_opened(tmp_path):
    name = (
        '<?xml version="1.0" encoding="ISO-8859-1"?>\n<!DOCTYPE svg PUBLIC '
        '"-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">\n'
    )
    assert read(tmp_path, name + page('<rect width="1" height="1"/>')).area_m2 == 79


@pytest.mark.slow
def test_uses_that_double_are_bounded(tmp_path):
    doubled = "".join(
        f'<g id="g{k}"><use href="#g{k - 1}"/><use href="#g{k - 1}"/></g>' for k in range(1, 40)
    )
    text = page(f'<defs><rect id="g0" width="1" height="1"/>{doubled}</defs><use href="#g39"/>')
    with pytest.raises(MapFormatError, match="more than 25,000 elements are drawn"):
        read(tmp_path, text)


def test_nesting_is_bounded(tmp_path):
    with pytest.raises(MapFormatError, match="nested more than 100 deep"):
        read(tmp_path, page("<g>" * 5000 + "</g>" * 5000))


def test_crossings_are_bounded(tmp_path):
    rng = np.random.default_rng(1)
    points = " ".join(f"{x:.3f} {y:.3f}" for x, y in rng.uniform(0, 8, (6000, 2)))
    for content in (f'<path d="M{points}"/>', f'<path d="M{points}" {BLACK} stroke-width=".01"/>'):
        with pytest.raises(MapFormatError, match="cross too often"):
            read(tmp_path, page(content))


def test_overlapping_strokes_are_bounded(tmp_path):
    lines = "".join(f'<path d="M{k / 900} 1h.1v.01h.1"/>' for k in range(6000))
    style = f'{BLACK} stroke-width="5" stroke-linejoin="round" stroke-linecap="round"'
    with pytest.raises(MapFormatError, match="cross too often"):
        read(tmp_path, page(f"<g {style}>{lines}</g>"))


@pytest.mark.parametrize(
    "text",
    [
        f"<svg {XMLNS}/>",
        "<?xml version='1.0'?>\n<!-- <svg> -->\n<!DOCTYPE svg>\n<s:svg xmlns:s='x'/>",
        "\ufeff<svg>",
    ],
)
def test_svg_is_recognised_by_its_root(tmp_path, text):
    path = tmp_path / "plan.xml"
    path.write_text(text)
    assert format_of(path).name == "SVG"


def test_another_root_is_named(tmp_path):
    path = tmp_path / "plan.svg"
    path.write_text("<html><svg/></html>")
    with pytest.raises(MapFormatError, match="has the root html"):
        read_environment(path, resolution_m=1.0)


# Damage.

SYMBOLS = page(
    '<symbol id="s" viewBox="0 0 9 9"><path d="M0 0Q1 2 4 4t2 5A1 1 0 0 1 9 9z"/></symbol>'
    '<use href="#s" width="2" height="2"/><clipPath id="c"><circle r="2"/></clipPath>'
    '<g clip-path="url(#c)"><rect width="9" height="9" rx="1"/></g>'
)
DOCUMENTS = [INKSCAPE, BY_HAND, CUBICASA, SYMBOLS]
TOKENS = sorted({token for text in DOCUMENTS for token in re.findall(r"[\w.#%-]+", text)})
NUMBERS = [
    "0",
    "-1",
    "1e300",
    "nan",
    "1e12",
    "-.5",
    "100%",
    "99999999",
    "1e-300",
    "inf",
    "5mm",
    "3",
    "7.5",
]


@st.composite
def damaged(draw):
    """A plan some of whose words are replaced, left out, doubled or moved."""
    words = re.split(r"([\w.#%-]+)", draw(st.sampled_from(DOCUMENTS)))  # every other is a sign
    kinds = ["number"] * 4 + ["word"] * 3 + ["swap", "double", "cut"]
    for _ in range(draw(st.integers(1, 5))):
        at = 2 * draw(st.integers(0, len(words) // 2 - 1)) + 1
        other = 2 * draw(st.integers(0, len(words) // 2 - 1)) + 1
        kind = draw(st.sampled_from(kinds))
        if kind == "word":
            words[at] = draw(st.sampled_from(TOKENS))
        elif kind == "number":
            numbers = [k for k, word in enumerate(words) if re.fullmatch(r"-?[\d.]+", word)]
            words[draw(st.sampled_from(numbers or [at]))] = draw(st.sampled_from(NUMBERS))
        elif kind == "cut" and len(words) > 100:
            del words[at : at + 2 * draw(st.integers(1, 20))]
        elif kind == "swap":
            words[at], words[other] = words[other], words[at]
        else:
            words[at:at] = words[at : at + 2 * draw(st.integers(1, 20))]
    return "".join(words)


@settings(max_examples=300, deadline=None)
@given(text=damaged(), resolution_m=st.sampled_from([None, 1.0, 0.01]))
def test_damage_raises_nothing_but_map_format_errors(tmp_path_factory, text, resolution_m):
    path = tmp_path_factory.getbasetemp() / "damaged.svg"
    path.write_text(text)
    with contextlib.suppress(MapFormatError):
        read_environment(path, resolution_m=resolution_m)


# What is said of layers that are read, and of those that are left out.

INK = 'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'


def layer(label, content):
    return f'<g inkscape:groupmode="layer" inkscape:label="{label}" id="layer1">{content}</g>'


SQUARE = '<rect id="rect1" x="1" y="1" width="2" height="2"/>'
LINE = '<g id="g12"><path id="p7" d="M0 0 h10" fill="none" stroke="#222"/></g>'


def test_layers_left_out_beside_furniture_are_told(tmp_path):
    world = read(tmp_path, page(layer("Layer 1", 3 * LINE) + layer("Furniture", SQUARE), more=INK))
    assert world.area_m2 == pytest.approx(76)
    assert str(world.layers) == (
        "layers read: Furniture (obstacles); left out: Layer 1 (3 shapes); "
        "name layers walls, obstacles, free, ... to read them"
    )
    assert not world.layers.bounds_space


def test_what_cannot_be_seen_is_not_left_out(tmp_path):
    hidden = '<rect width="9" height="9" fill="{}" {}/>'
    content = "".join(
        hidden.format(fill, more)
        for fill, more in (
            ("white", ""),
            ("none", ""),
            ("black", 'opacity="0.05"'),
            ("black", 'visibility="hidden"'),
            ("black", 'display="none"'),
        )
    )
    world = read(tmp_path, page(content + layer("Walls", SQUARE), more=INK))
    assert str(world.layers) == "layers read: Walls (walls)"
    assert world.layers.bounds_space


def test_shapes_without_a_layer_and_images_are_left_out(tmp_path):
    content = SQUARE + '<image width="2" height="2" href="scan.png"/>'
    world = read(tmp_path, page(content + '<path class="thin wall" d="M5 5h1v1z"/>'))
    assert [tuple(one) for one in world.layers.layers] == [
        ("", "", 2),
        ("wall", "walls", 1),
    ]
    assert "left out: what is in no layer (2 shapes)" in str(world.layers)


def test_many_layers_are_not_all_listed(tmp_path):
    content = "".join(f'<g id="part{n}">{LINE}</g>' for n in range(7))
    world = read(tmp_path, page(content + f'<g id="wall">{SQUARE}</g>'))
    assert "left out: part0 (1 shape), part1 (1 shape), " in str(world.layers)
    assert "part4 (1 shape) and 2 others; " in str(world.layers)


def test_plans_without_names_have_no_layers(tmp_path):
    assert read(tmp_path, page(layer("Layer 1", SQUARE), more=INK)).layers is None


def test_names_of_layers_cannot_control_a_terminal(tmp_path):
    world = read(
        tmp_path, page(layer("a&#x9b;m" + 99 * "x", LINE) + layer("cols", SQUARE), more=INK)
    )
    assert str(world.layers).isprintable()
    assert len(world.layers.left_out[0].name) == 40


def test_starts_outside_free_space_are_left_out_by_repairs(tmp_path):
    path = tmp_path / "plan.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 8">\n'
        '<rect class="wall" x="4" y="0" width="2" height="8"/>\n'
        '<circle class="start" cx="2" cy="3" r=".5"/>\n'
        '<path class="start" d="M1 1h1v1z M5 5h.1v.1z"/></svg>'
    )
    with pytest.raises(MapFormatError) as refused:
        read_environment(path, resolution_m=1.0)
    assert str(refused.value).startswith(
        f"{path}, line 4, <path>: the suggested start (5.05, 2.95) is not in free space, but "
        "0.95 m away from it; move it or remove it; 'multisrt environments check FILE --fix OUT'"
    )
    world = read_environment(path, resolution_m=1.0, repair=True)
    assert world.starts == ((2, 5), (1.5, 6.5))
    assert world.cleaning.removed_starts == 1
    assert world.area_m2 == 64


def test_equal_starts_count_once_and_of_many_the_first(tmp_path):
    path = tmp_path / "plan.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 2000 8">'
        '<rect class="wall" x="0" y="7" width="2000" height="1"/>'
        + '<circle class="start" cx="3" cy="3" r=".5"/>' * 2
        + "".join(f'<circle class="start" cx="{x}" cy="3" r=".5"/>' for x in range(5, 1500))
        + "</svg>"
    )
    starts = read_environment(path, resolution_m=1.0).starts
    assert starts[:2] == ((3, 5), (5, 5))
    assert len(starts) == MAX_STARTS


corners = st.integers(0, 12)


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(corners, corners, st.integers(0, 4), st.integers(1, 4)), max_size=12))
def test_a_union_in_groups_is_the_union(boxes):
    # Boxes that are apart, touch at corners or sides, overlap, are equal, or are empty.
    areas = [shapely.box(x, y, x + w, y + h) if w else Polygon() for x, y, w, h in boxes]
    whole = shapely.union_all(areas)
    grouped = union_of(areas)
    assert grouped.is_valid
    assert grouped.is_empty == whole.is_empty
    assert grouped.symmetric_difference(whole).area == 0
    assert len(shapely.get_parts(grouped)) == len(shapely.get_parts(whole))
    assert all(part.geom_type == "Polygon" for part in shapely.get_parts(grouped))
