"""Floor plans in SVG as worlds.

A plan is read in one of two ways. If layers, classes or identifiers name walls, obstacles or free
space, only shapes with such names count. Otherwise it is read by its appearance: the page is a wall
where its topmost paint is dark, and free space elsewhere.
"""

import re
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.environments.formats.files import (
    FileStarts,
    build_environment,
    require_number,
)
from multisrt.environments.formats.map_format import Beginning, MapFormat
from multisrt.environments.formats.plan import Role, layers_of, role_names
from multisrt.environments.formats.regions import (
    MAX_POINTS,
    opened,
    require_few_crossings,
    union_of,
)
from multisrt.environments.formats.svg.clips import Clipper
from multisrt.environments.formats.svg.lengths import SvgError
from multisrt.environments.formats.svg.page import Page, page_of
from multisrt.environments.formats.svg.shapes import (
    Outline,
    closed_area,
    fill_area,
    outline,
    stroke_area,
    stroke_sides,
)
from multisrt.environments.formats.svg.start_places import start_places
from multisrt.environments.formats.svg.styles import lightness_and_alpha, opacity
from multisrt.environments.formats.svg.tree import Document, Drawn
from multisrt.environments.formats.xml_text import read_xml, root_name
from multisrt.environments.layers import Layers
from multisrt.environments.own_pictures import is_own_layer
from multisrt.geometry.errors import MapFormatError
from multisrt.geometry.numerics.arrays import FloatArray

DARK_LIGHTNESS: Final = 0.5
"""Default threshold of lightness: paint that is not lighter is a wall."""

MAX_COVER_POINTS: Final = 1_000_000
"""Upper bound of the points of light shapes over dark ones, counted again for each dark one."""

MIN_CONTRAST: Final = 0.1
"""Minimum darkness, on white, of shapes that are said to be left out."""

MAX_OUTSIDE: Final = 0.01
"""Maximum share of the area of walls that may be outside the page."""


def read_svg(
    path: Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
    repair: bool = False,
) -> Environment:
    """Read a floor plan in SVG.

    **By names.** A shape has the role of the first of these words in its own label (Inkscape),
    class or identifier, or else in that of the nearest group: ``door``, ``obstacle`` (also
    ``column``, ``furniture``), ``wall`` (also ``window``), ``start``, ``free`` (also ``outline``);
    see `multisrt.environments.formats.plan.WORDS`. If any shape is a wall, an obstacle or free,
    only shapes with a role count. Free space is the area of the free shapes, or else the page,
    minus the areas of obstacles and the painted areas of walls (fills, and strokes at their
    width). Painted areas of doors are openings in walls. The centre of each subpath of a start is
    a suggested start (in pictures of runs, the centre of the symbol without its tip).

    **By lightness.** Without such names, free space is the page where its topmost paint is lighter
    than the threshold, and where nothing is painted. Text and dashed lines, by which plans show
    what is above the floor or hidden, are ignored.

    **Scale.** ``--resolution`` gives the metres per user unit. Without it, a page in mm, cm or
    inches is read at its own size if a side has at least 1.2 m; a smaller page is paper, and
    raises an error that asks for its scale. Pictures of this package are in metres.

    The origin is the lower left corner of the page, y is up; without a page (neither ``viewBox``
    nor ``width`` and ``height``) it is the corner of the bounding box of the shapes. Curves are
    replaced by polylines within 5 mm of them.

    Parameters
    ----------
    path : Path
        SVG 1.1 or 2 in UTF-8: paths, basic shapes, groups, transforms, ``use``, ``symbol``,
        ``clipPath``, attributes, ``style`` and simple rules of style sheets.
    resolution_m : float, optional
        Metres per user unit: a unit of the ``viewBox``, or else a pixel.
    threshold : float, optional
        Lightness in [0, 1] above which paint is free, by default 0.5. Only for plans without
        names.
    name : str, optional
        By default the file's name without suffix.
    repair : bool, optional
        Whether starts that are not in free space are left out instead of refused.

    Raises
    ------
    MapFormatError
        If the file is not such a drawing, has no scale and none is given, refers to other files,
        uses unsupported content (images, patterns, masks), has no walls or no free space, or has a
        start outside of it.

    Notes
    -----
    Source: W3C, Scalable Vector Graphics (SVG) 2, 2018; differs in: dashes, markers, text, filters
    and animations are not drawn, and invalid content raises an error.

    Examples
    --------
    >>> from pathlib import Path
    >>> plan = '''<svg viewBox="0 0 6 4" xmlns="http://www.w3.org/2000/svg">
    ...   <rect class="free" width="6" height="4"/>
    ...   <line class="wall" x1="3" x2="3" y2="2" stroke="black" stroke-width="0.5"/>
    ... </svg>'''
    >>> _ = Path("plan.svg").write_text(plan)
    >>> read_svg(Path("plan.svg"), resolution_m=1.0).area_m2
    23.0
    """
    document = Document(path, read_xml(path))
    try:
        page = page_of(document, resolution_m)
    except SvgError as error:
        raise document.wrong(document.root, error) from error
    shapes = list(document.drawn(page.element, page.matrix, page.viewport))
    plan = _Plan(document, page, shapes)
    if plan.has_names:
        if threshold is not None:
            raise MapFormatError(
                f"{path} has layers by name, which say what is free; leave out --threshold "
                f"(threshold); {plan.layers}"
            )
        free, rule = plan.free_by_names(), "walls by their names"
    else:
        level = (
            DARK_LIGHTNESS if threshold is None else require_number(path, "threshold", threshold)
        )
        if not 0.0 <= level <= 1.0:
            raise MapFormatError(f"{path}: the threshold is {level:g}; lightness is in [0, 1]")
        free = plan.free_by_lightness(level)
        rule = f"free above lightness {level:.3g}"
    x, y = plan.corner
    if page.frame is None:
        free = shapely.transform(free, lambda points: points - (x, y))
    return build_environment(
        path,
        free,
        name=name,
        origin=f"{path.name} {page.scale}, {rule}",
        starts=plan.starts(repair=repair),
        layers=plan.layers,
    )


class _Paint(NamedTuple):
    """An area that is painted, light or dark."""

    area: BaseGeometry
    is_light: bool


class _Plan:
    """The shapes of a document, and the free space that they determine."""

    def __init__(self, document: Document, page: Page, shapes: list[Drawn]) -> None:
        self._document = document
        self._path = document.path
        self._page = page
        named = {Role.FREE, Role.WALL, Role.OBSTACLE}
        self.has_names = any(one.role in named for one in shapes)
        self.layers: Layers | None = None
        if self.has_names:
            self.layers = layers_of(
                (one.named if one.role else one.layer, one.role)
                for one in shapes
                if one.role is not None
                or (_is_visible(one) and not (page.is_own and is_own_layer(one.layer)))
            )
            shapes = [one for one in shapes if one.role is not None]
        self._clipper = Clipper(document)
        self._shapes: list[tuple[Drawn, Outline]] = []
        sides: list[FloatArray] = []
        count = 0
        for one in shapes:
            if one.element.name == "image":
                if one.role is not Role.START:
                    raise document.wrong(
                        one.element, "images are not read; hide or delete it, or trace its walls"
                    )
                continue
            try:
                lines = outline(one)
                # Counted as they are made: symbols may be used very often.
                count += sum(len(points) for points, _ in lines.metres)
                if count > MAX_POINTS:
                    raise MapFormatError(
                        f"{self._path} has more than {MAX_POINTS:,} points, with curves as "
                        "polylines; simplify it"
                    )
                self._shapes.append((one, lines))
                sides += stroke_sides(one, lines, page.px_m)
            except SvgError as error:
                raise document.wrong(one.element, error) from error
        strings = [
            shapely.LineString(points)
            for _, outlines in self._shapes
            for points, _ in outlines.metres
            if len(points) > 1
        ]
        require_few_crossings(self._path, strings, sides)
        self._points = 0
        self.corner = (0.0, 0.0)

    def _count(self, area: BaseGeometry) -> None:
        self._points += int(shapely.get_num_coordinates(area))
        if self._points > MAX_POINTS:
            raise MapFormatError(
                f"{self._path}: its areas have more than {MAX_POINTS:,} points, with round caps "
                "and joins as polygons; simplify it"
            )

    def starts(self, *, repair: bool) -> FileStarts:
        """Return the suggested starts, from the corner that is the origin."""
        points: list[tuple[float, float]] = []
        places: list[str] = []
        for one, lines in self._shapes:
            if one.role is Role.START:
                try:
                    found = start_places(one, lines)
                except SvgError as error:
                    raise self._document.wrong(one.element, error) from error
                points += [(x - self.corner[0], y - self.corner[1]) for x, y in found]
                places += [self._document.place(one.element)] * len(found)
        return FileStarts(points, places, repair)

    def free_by_names(self) -> BaseGeometry:
        """Return free space where walls, obstacles or free space have names."""
        areas: dict[Role, list[BaseGeometry]] = {role: [] for role in Role}
        for one, lines in self._shapes:
            if one.role is None or one.role is Role.START:
                continue
            try:
                area = self._clipper.cut(one, self._named_area(one, lines))
                self._count(area)
                areas[one.role].append(area)
            except SvgError as error:
                raise self._document.wrong(one.element, error) from error
        require_few_crossings(self._path, [area for some in areas.values() for area in some])
        united = {role: union_of(some) for role, some in areas.items()}
        walls = opened(united[Role.WALL], united[Role.DOOR]) | united[Role.OBSTACLE]
        if areas[Role.FREE]:
            free = united[Role.FREE]
            if free.is_empty:
                raise MapFormatError(
                    f"{self._path}: the shapes named free or outline have no area; draw a closed "
                    "outline"
                )
            return self._placed(free, free - walls)
        if walls.is_empty:
            raise MapFormatError(
                f"{self._path}: the shapes named wall paint nothing; give them a stroke or a fill"
            )
        frame = self._frame(walls)
        return self._placed(frame, frame - walls)

    def _named_area(self, one: Drawn, lines: Outline) -> BaseGeometry:
        if one.role is Role.FREE:
            return fill_area(self._path, one, lines)
        if one.role is Role.OBSTACLE:
            closed = closed_area(self._path, one, lines)
            if not closed.is_empty:
                return closed
        color = one.style["color"]
        is_filled = _is_painted(one.style["fill"], color)
        area = fill_area(self._path, one, lines) if is_filled else Polygon()
        if _is_painted(one.style["stroke"], color):
            area = area | stroke_area(one, lines, self._page.px_m)
        return area

    def free_by_lightness(self, threshold: float) -> BaseGeometry:
        """Return free space where there are no names."""
        paints: list[_Paint] = []
        for one, lines in self._shapes:
            if one.role is not Role.START:
                try:
                    paints.extend(self._painted(one, lines, threshold))
                except SvgError as error:
                    raise self._document.wrong(one.element, error) from error
        require_few_crossings(self._path, [paint.area for paint in paints])
        walls = _topmost_dark(self._path, paints)
        if walls.is_empty:
            raise MapFormatError(
                f"{self._path} has no walls: no painted shape is darker than "
                f"{threshold:.3g}, and none is named; paint walls dark, give a higher --threshold "
                f"(threshold), or name layers {role_names()}"
            )
        frame = self._frame(walls)
        return self._placed(frame, frame - walls)

    def _painted(self, one: Drawn, lines: Outline, threshold: float) -> list[_Paint]:
        """Return what a shape paints: its fill below its stroke."""
        style = one.style
        paints = []
        for kind in ("fill", "stroke"):
            color = lightness_and_alpha(style[kind], style["color"])
            if color is None or (kind == "stroke" and _is_dashed(style["stroke-dasharray"])):
                continue
            lightness, alpha = color
            alpha *= one.opacity * opacity(style[f"{kind}-opacity"])
            # Light even on black, or dark even on white; else translucent paint is ignored.
            if alpha * lightness > threshold:
                is_light = True
            elif 1 - alpha * (1 - lightness) <= threshold:
                is_light = False
            else:
                continue
            area = (
                fill_area(self._path, one, lines)
                if kind == "fill"
                else stroke_area(one, lines, self._page.px_m)
            )
            area = self._clipper.cut(one, area)
            if not area.is_empty:
                self._count(area)
                paints.append(_Paint(area, is_light))
        return paints

    def _frame(self, walls: BaseGeometry) -> BaseGeometry:
        """Return the page, or else the bounding box of walls."""
        if self._page.frame is None:
            return shapely.box(*walls.bounds)
        outside = walls.difference(self._page.frame).area
        if outside > MAX_OUTSIDE * walls.area:
            raise MapFormatError(
                f"{self._path}: {outside / walls.area:.0%} of the walls are outside the page; "
                "resize the page to its content, or draw an outline of free space with that name"
            )
        return self._page.frame

    def _placed(self, frame: BaseGeometry, free: BaseGeometry) -> BaseGeometry:
        """Return free space, and note the corner that becomes the origin."""
        if free.is_empty:
            raise MapFormatError(f"{self._path}: walls cover everything, so there is no free space")
        if self._page.frame is None and self._page.element is self._document.root:
            self.corner = frame.bounds[:2]
        return free


def _is_painted(paint: str, color: str) -> bool:
    """Return whether something is painted, whatever its colour."""
    return paint.strip().lower() not in ("none", "transparent") and not (
        paint.strip().lower() == "currentcolor" and color.strip().lower() == "transparent"
    )


def _is_visible(one: Drawn) -> bool:
    """Return whether a shape is an image, or painted visibly on white."""
    if one.element.name == "image":
        return True
    for kind in ("fill", "stroke"):
        try:
            color = lightness_and_alpha(one.style[kind], one.style["color"])
            alpha = one.opacity * opacity(one.style[f"{kind}-opacity"])
        except SvgError:  # a paint that is not read
            return True
        if color is None or (kind == "stroke" and _is_dashed(one.style["stroke-dasharray"])):
            continue
        if color[1] * alpha * (1 - color[0]) > MIN_CONTRAST:
            return True
    return False


def _is_dashed(text: str) -> bool:
    return bool(re.search(r"[1-9]", text))


def _topmost_dark(path: Path, paints: list[_Paint]) -> BaseGeometry:
    """Return the area whose topmost paint is dark."""
    dark = [(k, paint.area) for k, paint in enumerate(paints) if not paint.is_light]
    light = [(k, paint.area) for k, paint in enumerate(paints) if paint.is_light]
    if not dark:
        return Polygon()
    visible = np.array([area for _, area in dark], np.object_)
    if light:
        tree = shapely.STRtree([area for _, area in light])
        order = np.array([k for k, _ in light])
        sizes = shapely.get_num_coordinates(tree.geometries)
        points = 0
        for index, (k, area) in enumerate(dark):
            later = tree.query(area, predicate="intersects")
            later = later[order[later] > k]
            if later.size:
                points += int(sizes[later].sum())
                if points > MAX_COVER_POINTS:
                    raise MapFormatError(
                        f"{path}: its dark shapes lie under too many light ones; remove hidden "
                        "shapes, or name layers " + role_names()
                    )
                cover = shapely.union_all(tree.geometries[np.sort(later)])
                visible[index] = opened(area, cover)
    return union_of(list(visible))


def _is_svg_file(beginning: Beginning) -> bool:
    return root_name(beginning.text) == "svg"


SVG = MapFormat(
    name="SVG",
    suffixes=(".svg",),
    recognises=_is_svg_file,
    read=read_svg,
    repair=partial(read_svg, repair=True),
)
