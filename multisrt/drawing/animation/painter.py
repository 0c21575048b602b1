"""The pictures of an animation as pixels, drawn with Pillow.

What appears is drawn once, on layers above one another; bodies and texts are drawn on a copy of
them for each picture. Everything is drawn twice as large and then reduced, as Pillow draws hard
edges.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Final, TypeVar

import numpy as np
from PIL import Image, ImageChops, ImageDraw, ImageFont

from multisrt.drawing.animation.growth import Piece
from multisrt.drawing.animation.looks import (
    BAR_PX,
    CUT_OFF_RING,
    GOAL_MM,
    HALO_MM,
    HEADING_MM,
    PROGRESS,
    RING,
    TRACK,
    area_fill,
    bar_width,
    body_fill,
    entry_text,
    goal_style,
    heading_colour,
    is_numbered,
    label_place,
    path_style,
    styles_of,
    title_texts,
)
from multisrt.drawing.animation.scene import Actor, Dot, Edge, Scene, Span, is_listed
from multisrt.drawing.colours import BASE, BASE_MM, INK, NODE_MM, OBSTACLE, WHITE, Style
from multisrt.drawing.svg import CORNERS, Marker, printable
from multisrt.geometry.numerics.kernel import FloatArray

LARGER: Final = 2
"""Factor by which pictures are drawn larger than they are."""

MAX_MARK_MM: Final = 1.5
"""Bound of the distance by which lines and nodes reach beyond their places."""

ThingT = TypeVar("ThingT", Piece, Edge, Dot)
Points = Sequence[tuple[float, float]]
Box = tuple[int, int, int, int]


class Painter:
    """Draws the pictures of a scene, in order.

    Parameters
    ----------
    scene : Scene
        What to draw.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene, self.layout = scene, scene.layout
        self._mm = scene.layout.mm * scene.layout.scale * LARGER
        self._unit = scene.layout.unit * LARGER
        size = (scene.layout.width * LARGER, scene.layout.height * LARGER)
        self._ground = Image.new("RGB", size, WHITE)
        self._walls = self._draw_walls(size)
        self._paths = Image.new("RGBA", size)
        self._trees = Image.new("RGBA", size)
        self._base = Image.new("RGB", size, WHITE)
        self._changed: list[Box] = [(0, 0, *size)]
        self._next = {"pieces": 0, "edges": 0, "dots": 0}
        self._shown = -1
        if self.layout.captioned:
            self._draw_title()
            self._draw_swatches()

    def picture(self, number: int) -> Image.Image:
        """Return a picture by its number; numbers must not decrease."""
        last = self.scene.pace.last
        number = min(number, last)
        self._advance(number)
        image = self._base.copy()
        draw = ImageDraw.Draw(image)
        if self.scene.base is not None:
            self._draw_marker(draw, "house", self.scene.base, BASE_MM, BASE)
        if "goals" in self.scene.layers:
            self._draw_goals(draw, number)
        if "bodies" in self.scene.layers:
            self._draw_bodies(draw, number)
        if self.layout.captioned:
            self._draw_time(draw, number)
        if is_listed(self.scene):
            self._draw_activities(draw, number)
        return image.reduce(LARGER)

    # What stays once it has appeared. ----------------------------------------------------

    def _advance(self, number: int) -> None:
        scene = self.scene
        for piece in self._due("pieces", scene.pieces, number):
            self._draw_piece(piece.rings, area_fill(piece.robot))
        if "paths" in scene.layers:
            self._draw_paths(self._shown, number)
        trees = ImageDraw.Draw(self._trees)
        for edge in self._due("edges", scene.edges, number):
            ends = self._at(edge.ends)
            self._draw_line(trees, ends, styles_of(edge.robot).edge)
            self._changed.append(self._box(ends))
        factor = scene.node_mm / NODE_MM[1]
        for dot in self._due("dots", scene.dots, number):
            style = styles_of(dot.robot).node.scaled(factor)
            self._draw_marker(trees, dot.marker, dot.place, scene.node_mm, style)
            self._changed.append(self._box(self._at([dot.place])))
        self._shown = number
        for box in self._changed:
            self._compose(box)
        self._changed = []

    def _due(self, name: str, things: Sequence[ThingT], number: int) -> Iterator[ThingT]:
        begin = end = self._next[name]
        while end < len(things) and things[end].picture <= number:
            end += 1
        self._next[name] = end
        yield from things[begin:end]

    def _compose(self, box: Box) -> None:
        part = self._ground.crop(box)
        for layer in (self._walls, self._paths, self._trees):
            own = layer.crop(box)
            part.paste(own, mask=own)
        self._base.paste(part, box)

    def _draw_piece(self, rings: Iterable[FloatArray], fill: str) -> None:
        # Overlapping rings leave holes where they overlap an even number of times.
        corners = [self._at(ring) for ring in rings]
        box = self._box([place for ring in corners for place in ring])
        width, height = box[2] - box[0], box[3] - box[1]
        if width <= 0 or height <= 0:
            return
        mask = Image.new("1", (width, height))
        for ring in corners:
            one = Image.new("1", mask.size)
            ImageDraw.Draw(one).polygon([(x - box[0], y - box[1]) for x, y in ring], fill=1)
            mask = ImageChops.logical_xor(mask, one)
        self._ground.paste(fill, box, mask)
        self._changed.append(box)

    def _draw_walls(self, size: tuple[int, int]) -> Image.Image:
        left, top, wide, high = (LARGER * length for length in self.layout.map)
        layer = Image.new("RGBA", size)
        draw = ImageDraw.Draw(layer)
        draw.rectangle((left, top, left + wide, top + high), fill=OBSTACLE.fill)
        for part in self.scene.environment.free.geoms:
            draw.polygon(self._at(part.exterior.coords), fill=(0, 0, 0, 0))
            for hole in part.interiors:
                draw.polygon(self._at(hole.coords), fill=OBSTACLE.fill)
            for ring in (part.exterior, *part.interiors):
                self._draw_line(draw, self._at(ring.coords), OBSTACLE)
        draw.rectangle(
            (left, top, left + wide, top + high), outline=INK, width=self._wide(OBSTACLE)
        )
        return layer

    def _draw_paths(self, before: int, number: int) -> None:
        pace = self.scene.pace
        begin_s, end_s = pace.time_s(max(0, before)), pace.time_s(number)
        if begin_s >= end_s:
            return
        draw = ImageDraw.Draw(self._paths)
        for robot, actor in enumerate(self.scene.actors):
            points = self._at(actor.way.path(begin_s, end_s))
            if len(set(points)) > 1:
                self._draw_line(draw, points, path_style(robot, actor))
                self._changed.append(self._box(points))

    # What moves. -------------------------------------------------------------------------

    def _draw_goals(self, draw: ImageDraw.ImageDraw, number: int) -> None:
        for robot, actor in enumerate(self.scene.actors):
            due = [goal for goal in actor.goals if goal.picture <= number]
            if due and due[-1].place is not None:
                self._draw_marker(draw, "diamond", due[-1].place, GOAL_MM, goal_style(robot))

    def _draw_bodies(self, draw: ImageDraw.ImageDraw, number: int) -> None:
        for robot, actor in enumerate(self.scene.actors):
            self._draw_body(draw, robot, actor, number)

    def _draw_body(self, draw: ImageDraw.ImageDraw, robot: int, actor: Actor, number: int) -> None:
        x, y, heading = actor.way.at(self.scene.pace.time_s(number))
        doing = _shown(actor.activities, number)
        if doing == "cut off":
            angles = np.linspace(0.0, 2.0 * math.pi, 61)
            ring = RING * actor.outer_m * np.column_stack([np.cos(angles), np.sin(angles)])
            self._draw_line(draw, self._at(np.array((x, y)) + ring), CUT_OFF_RING)
        self._draw_outline(draw, robot, actor, (x, y, heading), body_fill(robot, doing))
        if is_numbered(self.scene):
            size = LARGER * self.layout.label_px
            [(px, py)] = self._at([(x, y)])
            away = label_place(LARGER * self.layout.scale * actor.outer_m, size)
            draw.text(
                (px + away, py - away),
                str(robot),
                INK,
                _font(round(size)),
                "mm",
                stroke_width=round(0.12 * size),
                stroke_fill=WHITE,
            )

    def _draw_outline(
        self,
        draw: ImageDraw.ImageDraw,
        robot: int,
        actor: Actor,
        pose: tuple[float, float, float],
        fill: str,
    ) -> None:
        x, y, heading = pose
        cos, sin = math.cos(heading), math.sin(heading)
        turn = np.array([[cos, sin], [-sin, cos]])
        style = styles_of(robot).end
        if actor.radius_m is None:
            outline = self._at(actor.outline @ turn + (x, y))
            closed = [*outline, outline[0], outline[1]]
            self._draw_line(draw, closed, Style(stroke=WHITE, width_mm=HALO_MM))
            draw.polygon(outline, fill=fill)
            self._draw_line(draw, closed, style)
        else:
            [(px, py)] = self._at([(x, y)])
            radius = LARGER * self.layout.scale * actor.radius_m
            for more, colour in ((HALO_MM, WHITE), (style.width_mm, style.stroke), (0.0, fill)):
                r = radius + 0.5 * more * self._mm
                draw.ellipse((px - r, py - r, px + r, py + r), fill=colour)
        front = np.array([(0.0, 0.0), (actor.front_m, 0.0)]) @ turn + (x, y)
        line = Style(stroke=heading_colour(fill), width_mm=HEADING_MM)
        self._draw_line(draw, self._at(front), line)

    # Texts. ------------------------------------------------------------------------------

    def _draw_title(self) -> None:
        draw = ImageDraw.Draw(self._ground)
        left, _, wide, _ = (LARGER * length for length in self.layout.map)
        y, size = LARGER * self.layout.title_y, LARGER * self.layout.title_px
        title, speed = title_texts(self.scene)
        # The font has no bold letters.
        bold = size / 40.0
        font = _font(round(size))
        draw.text((left, y), printable(title), INK, font, "lm", stroke_width=bold, stroke_fill=INK)
        self._write(draw, (left + wide, y), speed, "rm")

    def _draw_swatches(self) -> None:
        draw = ImageDraw.Draw(self._ground)
        side = LARGER * self.layout.swatch_px
        for robot in range(len(self.scene.actors) if is_listed(self.scene) else 0):
            x, y = (LARGER * length for length in self.layout.entry(robot))
            box = (x, y - side / 2.0, x + side, y + side / 2.0)
            draw.rectangle(box, fill=body_fill(robot, "moves"))

    def _draw_time(self, draw: ImageDraw.ImageDraw, number: int) -> None:
        left, _, wide, _ = (LARGER * length for length in self.layout.map)
        y = LARGER * (self.layout.caption_y + 0.5 * self.layout.row_px)
        half = BAR_PX * self._unit / 2.0
        bar = LARGER * bar_width(self.scene)
        done = bar * number / self.scene.pace.last
        if bar > 0.0:
            draw.rectangle((left, y - half, left + bar, y + half), fill=TRACK)
        if done >= 1.0:
            draw.rectangle((left, y - half, left + done, y + half), fill=PROGRESS)
        text = _shown(self.scene.captions, number)
        self._write(draw, (left + wide, y), text, "rm")

    def _draw_activities(self, draw: ImageDraw.ImageDraw, number: int) -> None:
        for robot, actor in enumerate(self.scene.actors):
            x, y = (LARGER * length for length in self.layout.entry(robot))
            text = entry_text(robot, _shown(actor.activities, number))
            self._write(draw, (x + 1.5 * LARGER * self.layout.swatch_px, y), text, "lm")

    def _write(
        self,
        draw: ImageDraw.ImageDraw,
        place: tuple[float, float],
        text: str,
        anchor: str,
    ) -> None:
        font = _font(round(LARGER * self.layout.text_px))
        draw.text(place, printable(text), INK, font, anchor)

    # Shapes. -----------------------------------------------------------------------------

    def _at(self, places: Iterable[Sequence[float]] | FloatArray) -> list[tuple[float, float]]:
        """Return places in metres as pixels."""
        at = np.asarray(places if isinstance(places, np.ndarray) else list(places), np.float64)
        x, y = self.layout.origin
        scale = self.layout.scale
        pixels = LARGER * np.column_stack([x + scale * at[:, 0], y - scale * at[:, 1]])
        return [(float(px), float(py)) for px, py in pixels]

    def _box(self, points: Points) -> Box:
        # Around points, with room for lines and markers.
        at, room = np.asarray(points), 1 + math.ceil(MAX_MARK_MM * self._mm)
        x0, y0 = np.floor(at.min(axis=0)).astype(int) - room
        x1, y1 = np.ceil(at.max(axis=0)).astype(int) + room
        width, height = self._ground.size
        return max(0, int(x0)), max(0, int(y0)), min(width, int(x1)), min(height, int(y1))

    def _wide(self, style: Style) -> int:
        return max(1, round(style.width_mm * self._mm))

    def _draw_line(self, draw: ImageDraw.ImageDraw, points: Points, style: Style) -> None:
        if style.stroke is None:
            return
        width = self._wide(style)
        colour = style.stroke
        if style.stroke_opacity < 1.0:
            colour += f"{round(255 * style.stroke_opacity):02x}"
        lines = [list(points)]
        if style.dashes_mm:
            lines = list(dashes(points, [dash * self._mm for dash in style.dashes_mm]))
        for line in lines:
            draw.line(line, fill=colour, width=width, joint="curve")

    def _draw_marker(
        self,
        draw: ImageDraw.ImageDraw,
        marker: Marker,
        place: tuple[float, float],
        size_mm: float,
        style: Style,
    ) -> None:
        [(x, y)] = self._at([place])
        size, width = size_mm * self._mm, self._wide(style)
        if marker == "disc":
            box = (x - size, y - size, x + size, y + size)
            draw.ellipse(box, fill=style.fill, outline=style.stroke, width=width)
            return
        corners = [(x + size * u, y - size * v) for u, v in CORNERS[marker]]
        draw.polygon(corners, fill=style.fill)
        draw.line([*corners, *corners[:2]], fill=style.stroke, width=width, joint="curve")


def dashes(points: Points, lengths: Sequence[float]) -> Iterator[list[tuple[float, float]]]:
    """Yield the dashes of a line.

    Parameters
    ----------
    points : sequence of (x, y)
        The line.
    lengths : sequence of float
        Lengths of dashes and gaps in turn.

    Yields
    ------
    list of (x, y)
        The points of one dash.

    Examples
    --------
    >>> list(dashes([(0.0, 0.0), (5.0, 0.0)], [2.0, 1.0]))
    [[(0.0, 0.0), (2.0, 0.0)], [(3.0, 0.0), (5.0, 0.0)]]
    """
    which, left = 0, lengths[0]
    dash = [points[0]]
    for a, b in pairwise(points):
        whole, done = math.dist(a, b), 0.0
        while whole - done > left:
            done += left
            share = done / whole
            place = (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]))
            if which % 2 == 0:
                yield [*dash, place]
            which = (which + 1) % len(lengths)
            left, dash = lengths[which], [place]
        left -= whole - done
        if which % 2 == 0:
            dash.append(b)
    if which % 2 == 0 and len(dash) > 1:
        yield dash


def _shown(spans: Sequence[Span], number: int) -> str:
    return next((span.shown for span in reversed(spans) if span.begin <= number), "")


@lru_cache(maxsize=8)
def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(max(1, size))
