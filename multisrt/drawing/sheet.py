"""A sheet of paper with a map on it: heading above, scale bar and legend below.

User units are metres. Everything but the map is measured in millimetres on paper, so that a
picture of a room and one of a campus are equally readable.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from multisrt.drawing.colours import FREE, FREE_SAMPLE, INK, OBSTACLE, WHITE, Style
from multisrt.drawing.svg import (
    Bounds,
    Marker,
    Pen,
    child,
    layer,
    length,
    plain,
    printable,
    set_attributes,
    text_width,
)
from multisrt.environments.environment import Environment
from multisrt.events import Point

MAX_MAP_MM: Final = ((265.0, 160.0), (180.0, 225.0))
"""Width and height that bound the map: with its texts it fits A4, landscape or portrait."""

MIN_WEIGHT: Final = 0.6
"""Lower bound of the scale of lines and markers, so that they stay visible."""

CORRIDOR_MM: Final = 10.0
"""Width of typical passages on paper from which on lines and markers have their full size."""

MIN_WIDTH_MM: Final = 150.0
"""Minimum width of the sheet without margins, for heading and legend."""

MARGIN_MM: Final = 8.0
GAP_MM: Final = 2.0
FRAME_MM: Final = 2.0
"""Width of the surroundings that are drawn around free space."""

HEADING_MM: Final = 4.4
TEXT_MM: Final = 3.1
LINE: Final = 1.4
"""Distance of lines of text, as a multiple of their size."""

SAMPLE_MM: Final = 8.0
"""Width of a sample in the legend."""

MAX_BAR_MM: Final = 45.0
"""Upper bound of the length of the scale bar."""

MAX_HEADING: Final = 400
"""Upper bound of the characters in a line of the heading; longer lines are cut."""

FONT: Final = "Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif"


@dataclass(frozen=True, slots=True, kw_only=True)
class LegendEntry:
    """An entry of the legend.

    Attributes
    ----------
    label : str
        Text of the entry.
    style : Style
        Style of its sample.
    marker : Marker, optional
        Shape of a marker; by default the sample is a line or an area, by the style.
    size_mm : float, optional
        Size of the marker.
    """

    label: str
    style: Style
    marker: Marker | None = None
    size_mm: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Swatch:
    """The colours of one robot.

    Attributes
    ----------
    label : str
        Text beside the sample.
    area, line : Style
        Styles of the areas and lines of the robot.
    """

    label: str
    area: Style
    line: Style


class Sheet:
    """A sheet with a map of a world.

    Parameters
    ----------
    environment : Environment
        The world.
    heading : sequence of str
        Lines above the map; the first one is the title.
    description : str
        Description of the document, for programs.
    bounds_mm : sequence of (width, height), optional
        Bounds of the map on paper, of which the one is used that makes it larger.

    Attributes
    ----------
    mm : float
        Metres of the world per millimetre on paper.
    weight : float
        Scale of lines and markers, from `MIN_WEIGHT` to 1; below 1 where passages are narrow on
        paper.
    pen : Pen
        Writer of coordinates of the world.
    legend : list of LegendEntry
        Entries below the map.
    swatches : list of Swatch
        Colours of robots, below the legend.
    swatches_heading : str
        Heading of the swatches.
    heading : tuple of str
        Lines above the map.
    map : Element
        The map, with a group for each layer.
    map_mm : (width, height)
        Its size on paper, in millimetres.
    bounds : (x0, y0, x1, y1)
        Its bounds in metres, with a frame around free space.
    """

    def __init__(
        self,
        environment: Environment,
        heading: Sequence[str],
        description: str,
        bounds_mm: Sequence[tuple[float, float]] = MAX_MAP_MM,
    ) -> None:
        x0, y0, x1, y1 = environment.bounds
        self.mm = 1.0 / max(min(w / (x1 - x0), h / (y1 - y0)) for w, h in bounds_mm)
        self.weight = _weight(environment, self.mm)
        frame = FRAME_MM * self.mm
        self.pen = Pen.for_bounds(environment.bounds)
        self.legend: list[LegendEntry] = []
        self.swatches: list[Swatch] = []
        self.swatches_heading = ""
        self.min_number_mm = 0.0
        self.heading = tuple(heading)
        self.bounds: Bounds = (x0 - frame, y0 - frame, x1 + frame, y1 + frame)
        self.map_mm = ((x1 - x0) / self.mm + 2 * FRAME_MM, (y1 - y0) / self.mm + 2 * FRAME_MM)
        self._width_mm = max(self.map_mm[0], MIN_WIDTH_MM)
        self._root = ET.Element(
            "svg",
            {
                "xmlns": "http://www.w3.org/2000/svg",
                "xmlns:inkscape": "http://www.inkscape.org/namespaces/inkscape",
                "version": "1.1",
            },
        )
        child(self._root, "title", heading[0])
        child(self._root, "desc", f"{description} {self._units()}")
        self._paper = child(layer(self._root, "paper"), "rect", fill=WHITE)
        below = self._write_heading(heading)
        self.map = self._map_group(below + GAP_MM)
        self._y_mm = below + GAP_MM + self.map_mm[1] + GAP_MM

    def metres(self, size_mm: float) -> float:
        """Return the size of a marker or the width of a line on the map, in metres."""
        return size_mm * self.weight * self.mm

    def attributes(self, style: Style) -> dict[str, str]:
        """Return the SVG attributes of a style for shapes on the map."""
        return style.attributes(self.metres(1.0))

    def layer(self, label: str, style: Style | None = None, **attributes: str) -> ET.Element:
        """Add a layer above all others of the map and return it; its units are metres, y up."""
        group = layer(self.map, label)
        set_attributes(group, {} if style is None else self.attributes(style))
        set_attributes(group, attributes)
        return group

    def draw_ground(self, label: str) -> None:
        """Draw the ground of the map, and name it in the legend."""
        child(self.layer("free space", FREE), "path", d=self._frame())
        self.legend.append(LegendEntry(label=label, style=FREE_SAMPLE))

    def draw_obstacles(self, environment: Environment) -> None:
        """Draw obstacles and surroundings over what has been drawn."""
        rings = [r for part in environment.free.geoms for r in (part.exterior, *part.interiors)]
        path = self._frame() + self.pen.rings(ring.coords for ring in rings)
        child(self.layer("obstacles", OBSTACLE, fill_rule="evenodd"), "path", d=path)
        self.legend.append(LegendEntry(label="obstacle", style=OBSTACLE))

    def label(
        self, parent: ET.Element, text: str, place: Point, size_mm: float, halo_mm: float = 0.0
    ) -> None:
        """Write a short upright text, centred at a place in metres."""
        x, y = place[0] - self.pen.origin[0], place[1] - self.pen.origin[1]
        halo: dict[str, str | float] = {"stroke": "none"}
        if halo_mm:
            halo = {"stroke": WHITE, "stroke_width": halo_mm, "paint_order": "stroke"}
        child(
            parent,
            "text",
            text,
            y=0.36 * size_mm,
            font_size=size_mm,
            font_family=FONT,
            font_weight="bold",
            text_anchor="middle",
            fill=INK,
            **halo,
            transform=f"translate({plain(x)} {plain(y)}) scale({plain(self.mm)} {plain(-self.mm)})",
        )

    def svg(self) -> str:
        """Add scale bar and legend, and return the document."""
        below = self._write_legend(self._write_scale_bar(self._y_mm))
        if self.swatches:
            below = self._write_swatches(below + GAP_MM)
        width, height = self._width_mm + 2 * MARGIN_MM, below + MARGIN_MM
        in_metres = {"width": plain(width * self.mm), "height": plain(height * self.mm)}
        set_attributes(self._paper, in_metres)
        self._root.set("width", f"{plain(width)}mm")
        self._root.set("height", f"{plain(height)}mm")
        self._root.set("viewBox", f"0 0 {in_metres['width']} {in_metres['height']}")
        # In a browser's window that is narrower than the paper, the whole sheet is shown.
        self._root.set("style", "max-width:100%;height:auto")
        ET.indent(self._root, " ")
        body = ET.tostring(self._root, encoding="unicode")
        return f'<?xml version="1.0" encoding="UTF-8"?>\n{body}\n'

    def map_svg(self, title: str) -> str:
        """Return the map alone as a document, without names of layers."""
        x0, y0, x1, y1 = self.bounds
        width, height = x1 - x0, y1 - y0
        root = ET.Element("svg", {"xmlns": "http://www.w3.org/2000/svg"})
        root.set("viewBox", f"0 0 {plain(width)} {plain(height)}")
        child(root, "title", title)
        group = child(root, "g")
        left, up = x0 - self.pen.origin[0], y1 - self.pen.origin[1]
        group.set("transform", f"translate({plain(-left)} {plain(up)}) scale(1 -1)")
        for layer_ in self.map:
            if len(layer_):
                names = ("id", "inkscape:label", "inkscape:groupmode")
                kept = {k: v for k, v in layer_.attrib.items() if k not in names}
                ET.SubElement(group, "g", kept).extend(layer_)
        return ET.tostring(root, encoding="unicode") + "\n"

    def _units(self) -> str:
        x, y = self.pen.origin
        place = f" from ({x:.0f}, {y:.0f})" if x or y else ""
        return f"Coordinates of the layer 'map' are metres{place}, y up."

    def _map_group(self, top_mm: float) -> ET.Element:
        x0, _, _, y1 = self.bounds
        left_mm = MARGIN_MM + (self._width_mm - self.map_mm[0]) / 2.0
        right = left_mm * self.mm - (x0 - self.pen.origin[0])
        down = top_mm * self.mm + (y1 - self.pen.origin[1])
        group = layer(self._root, "map")
        group.set("transform", f"translate({plain(right)} {plain(down)}) scale(1 -1)")
        return group

    def _frame(self) -> str:
        x0, y0, x1, y1 = self.bounds
        return self.pen.rings([[(x0, y0), (x1, y0), (x1, y1), (x0, y1)]])

    def _paper_layer(self, label: str) -> ET.Element:
        # A layer whose units are millimetres on paper, y down.
        group = layer(self._root, label)
        values = {"font_family": FONT, "font_size": plain(TEXT_MM), "fill": INK}
        set_attributes(group, {"transform": f"scale({plain(self.mm)})", **values})
        return group

    def _write_heading(self, heading: Sequence[str]) -> float:
        group = self._paper_layer("heading")
        y = MARGIN_MM
        for number, paragraph in enumerate(heading):
            size, weight = (HEADING_MM, "bold") if number == 0 else (TEXT_MM, "normal")
            for line in wrapped(paragraph, size, self._width_mm):
                # The baseline is at y; capitals are about 0.75 of the size high.
                child(
                    group,
                    "text",
                    line,
                    x=MARGIN_MM,
                    y=y + 0.75 * size,
                    font_size=size,
                    font_weight=weight,
                )
                y += LINE * size
        return y

    def _write_scale_bar(self, top_mm: float) -> float:
        group = self._paper_layer("scale bar")
        bar = round_length(MAX_BAR_MM * self.mm)
        x, y = MARGIN_MM + 0.3, top_mm + 2.0
        end = x + bar / self.mm
        path = f"M{plain(x)} {plain(y - 1.2)}v2.4M{plain(x)} {plain(y)}H{plain(end)}m0-1.2v2.4"
        child(group, "path", d=path, fill="none", stroke=INK, stroke_width=0.5)
        child(group, "text", length(bar), x=end + 2.0, y=y + 0.36 * TEXT_MM)
        return top_mm + 4.0 + GAP_MM

    def _write_legend(self, top_mm: float) -> float:
        group = self._paper_layer("legend")
        widest = max(text_width(entry.label, TEXT_MM) for entry in self.legend)
        column_mm = SAMPLE_MM + 2.0 + widest + 3.0
        columns = max(1, math.floor((self._width_mm + 3.0) / column_mm))
        rows = math.ceil(len(self.legend) / columns)
        row_mm = 1.6 * TEXT_MM
        for k, entry in enumerate(self.legend):
            column, row = divmod(k, rows)
            x, y = MARGIN_MM + column * column_mm, top_mm + (row + 0.5) * row_mm
            _sample(group, entry, x, y, self.weight)
            child(group, "text", entry.label, x=x + SAMPLE_MM + 2.0, y=y + 0.36 * TEXT_MM)
        return top_mm + rows * row_mm

    def _write_swatches(self, top_mm: float) -> float:
        group = self._paper_layer("swatches")
        row_mm = 1.6 * TEXT_MM
        y = top_mm + 0.5 * row_mm
        child(group, "text", self.swatches_heading, x=MARGIN_MM, y=y + 0.36 * TEXT_MM)
        widest = max(text_width(swatch.label, TEXT_MM) for swatch in self.swatches)
        column_mm = SAMPLE_MM + 1.0 + widest + 2.0
        columns = max(1, math.floor((self._width_mm + 2.0) / column_mm))
        rows = math.ceil(len(self.swatches) / columns)
        for k, swatch in enumerate(self.swatches):
            column, row = divmod(k, rows)
            x, y = MARGIN_MM + column * column_mm, top_mm + (row + 1.5) * row_mm
            _sample(group, LegendEntry(label="", style=swatch.area), x, y, self.weight)
            _sample(group, LegendEntry(label="", style=swatch.line), x, y, self.weight)
            child(group, "text", swatch.label, x=x + SAMPLE_MM + 1.0, y=y + 0.36 * TEXT_MM)
        return top_mm + (rows + 1) * row_mm


def wrapped(text: str, size: float, width: float) -> list[str]:
    """Return the lines of text broken to a width; words that are wider are broken as well."""
    lines = [""]
    for word in shortened(printable(text)).split(" "):
        longer = f"{lines[-1]} {word}".strip()
        if text_width(longer, size) <= width:
            lines[-1] = longer
            continue
        if lines[-1]:
            lines.append("")
        for letter in word:
            if text_width(lines[-1] + letter, size) > width:
                lines.append("")
            lines[-1] += letter
    return lines


def shortened(text: str) -> str:
    """Return text of at most `MAX_HEADING` letters; an ellipsis marks a cut."""
    return text if len(text) <= MAX_HEADING else text[: MAX_HEADING - 1] + "…"


def round_length(longest: float) -> float:
    """Return the largest number of the form 1, 2 or 5 times a power of ten up to a length.

    Examples
    --------
    >>> round_length(7.3), round_length(0.19), round_length(20.0)
    (5.0, 0.1, 20.0)
    """
    power = math.floor(math.log10(longest))
    candidates = [float(f"{m}e{p}") for p in (power - 1, power, power + 1) for m in (1, 2, 5)]
    return max(c for c in candidates if c <= longest)


def _weight(environment: Environment, mm: float) -> float:
    # A corridor of length l and width w has the area l w and about the perimeter 2 l.
    free = environment.free
    passage_mm = 2.0 * free.area / free.length / mm
    return min(1.0, max(MIN_WEIGHT, passage_mm / CORRIDOR_MM))


def _sample(parent: ET.Element, entry: LegendEntry, x: float, y: float, weight: float) -> None:
    # The y axis of samples points up, as on the map.
    drawn = entry.style.attributes(weight)
    place = f"translate({plain(x + SAMPLE_MM / 2)} {plain(y)}) scale(1 -1)"
    half = SAMPLE_MM / 2.0
    if entry.marker is not None:
        path = Pen(decimals=3).marker(entry.marker, 0.0, 0.0, entry.size_mm * weight)
    elif entry.style.fill is not None:
        path = f"M{plain(-half + 0.5)}-1.4h{plain(SAMPLE_MM - 1.0)}v2.8h{plain(1.0 - SAMPLE_MM)}z"
    else:
        path = f"M{plain(-half)} 0h{plain(SAMPLE_MM)}"
    child(parent, "path", d=path, transform=place, **drawn)
