"""An animation as an SVG document that moves by itself, by SMIL: without any script.

Without animations the document shows the end of the run, and so it does for readers who prefer
reduced motion. Times are shares of the whole animation, which repeats.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Final

import numpy as np

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
from multisrt.drawing.colours import BASE, BASE_MM, FREE, INK, NODE_MM, OBSTACLE, WHITE
from multisrt.drawing.sheet import FONT
from multisrt.drawing.svg import Pen, child, number, set_attributes

SHARE_DECIMALS: Final = 5
"""Decimals of times, as shares of the animation."""

STYLE: Final = (
    "@media(prefers-reduced-motion:reduce){"
    ".shown{visibility:visible!important}"
    ".passing{visibility:hidden!important}"
    ".path{stroke-dashoffset:0!important}"
    ".bar{display:none}"
    ".moving{display:none}"
    ".still{display:inline}}"
)
"""For readers who prefer reduced motion: the end of the run, at rest."""


def moving_svg(scene: Scene, description: str) -> str:
    """Return the document of a scene; equal scenes give equal documents."""
    return _Document(scene, description).text()


class _Document:
    def __init__(self, scene: Scene, description: str) -> None:
        self.scene, self.pace, self.layout = scene, scene.pace, scene.layout
        pen = Pen.for_bounds(scene.environment.bounds)
        decimals = max(0, math.ceil(math.log10(4.0 * self.layout.scale)))
        self.pen = replace(pen, decimals=decimals)
        self._clock = {"dur": f"{_plain(self.pace.total_s, 3)}s", "repeatCount": "indefinite"}
        size = {"width": str(self.layout.width), "height": str(self.layout.height)}
        self.root = ET.Element(
            "svg",
            {
                "xmlns": "http://www.w3.org/2000/svg",
                "viewBox": f"0 0 {size['width']} {size['height']}",
                **size,
                "role": "img",
            },
        )
        child(self.root, "title", scene.title)
        child(self.root, "desc", description)
        child(self.root, "style", STYLE)
        child(self.root, "rect", **size, fill=WHITE)

    def text(self) -> str:
        if self.layout.captioned:
            self._write_title()
        self._write_map()
        if self.layout.captioned:
            self._write_time()
        if is_listed(self.scene):
            self._write_list()
        body = ET.tostring(self.root, encoding="unicode")
        return f'<?xml version="1.0" encoding="UTF-8"?>\n{body}\n'

    # What changes. -----------------------------------------------------------------------

    def _animate(
        self,
        parent: ET.Element,
        attribute: str,
        values: Sequence[str],
        shares: Iterable[float],
        **more: str,
    ) -> None:
        # A value that never changes needs no animation.
        if len(set(values)) < 2:
            return
        tag = "animateTransform" if attribute == "transform" else "animate"
        element = ET.SubElement(parent, tag, {"attributeName": attribute, **more})
        element.set("values", ";".join(values))
        element.set("keyTimes", ";".join(_plain(share, SHARE_DECIMALS) for share in shares))
        for name, value in self._clock.items():
            element.set(name, value)

    def _appear(self, element: ET.Element, picture: int) -> None:
        if picture > 0:
            element.set("class", "shown")
            shares = (0.0, self.pace.share_of(picture))
            self._animate(element, "visibility", ("hidden", "visible"), shares, calcMode="discrete")

    def _pass(self, element: ET.Element, span: Span, *, last: bool) -> None:
        # Shown from one picture until another; the last one stays.
        begin, end = (self.pace.share_of(picture) for picture in span[:2])
        values, shares = ["visible"], [0.0]
        if span.begin > 0:
            values, shares = ["hidden", "visible"], [0.0, begin]
        if not last:
            values.append("hidden")
            shares.append(end)
            element.set("visibility", "hidden")
        element.set("class", "shown" if last else "passing")
        self._animate(element, "visibility", values, shares, calcMode="discrete")

    # The map. ----------------------------------------------------------------------------

    def _write_map(self) -> None:
        x, y = self.layout.origin
        scale = self.layout.scale
        right, down = x + scale * self.pen.origin[0], y - scale * self.pen.origin[1]
        place = f"translate({_plain(right)} {_plain(down)}) scale({_plain(scale)} {_plain(-scale)})"
        self.map = child(self.root, "g", id="map", transform=place)
        frame = self.pen.rings([self._frame()])
        child(self.map, "path", d=frame, **FREE.attributes(self.layout.mm))
        self._write_areas()
        free = self.scene.environment.free.geoms
        rings = [ring for part in free for ring in (part.exterior, *part.interiors)]
        path = frame + self.pen.rings(ring.coords for ring in rings)
        walls = OBSTACLE.attributes(self.layout.mm)
        child(self.map, "path", id="walls", d=path, fill_rule="evenodd", **walls)
        layers = self.scene.layers
        if "paths" in layers:
            self._write_paths()
        self._write_trees()
        if self.scene.base is not None:
            mm = self.layout.mm
            house = self.pen.marker("house", *self.scene.base, BASE_MM * mm)
            child(self.map, "path", id="base", d=house, **BASE.attributes(mm))
        if "goals" in layers:
            self._write_goals()
        if "bodies" in layers:
            self._write_bodies()

    def _frame(self) -> list[tuple[float, float]]:
        left, top, wide, high = self.layout.map
        scale, (x, y) = self.layout.scale, self.layout.origin
        x0, x1 = (left - x) / scale, (left + wide - x) / scale
        y0, y1 = (y - top - high) / scale, (y - top) / scale
        return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]

    def _write_areas(self) -> None:
        layer = child(self.map, "g", id="areas", fill_rule="evenodd")
        for picture, group in groupby(self.scene.pieces, lambda piece: piece.picture):
            step = child(layer, "g")
            self._appear(step, picture)
            for piece in group:
                path = self.pen.rings(piece.rings)
                child(step, "path", d=path, fill=area_fill(piece.robot))

    def _write_paths(self) -> None:
        layer = child(self.map, "g", id="paths", fill="none", stroke_linejoin="round")
        for robot, actor in enumerate(self.scene.actors):
            lengths = actor.way.lengths_m
            if lengths[-1] <= 0.0:
                continue
            path = child(layer, "path", d=self.pen.line(actor.way.places), pathLength="1")
            style = path_style(robot, actor)
            set_attributes(path, style.attributes(self.layout.mm))
            set_attributes(
                path, {"class": "path", "stroke_dasharray": "1", "stroke_linecap": "butt"}
            )
            left = [_plain(rest, SHARE_DECIMALS) for rest in 1.0 - lengths / lengths[-1]]
            self._keyed(path, "stroke-dashoffset", left, actor.way.times_s)

    def _write_trees(self) -> None:
        layer = child(self.map, "g", id="trees", stroke_linejoin="round", stroke_linecap="round")
        edges: dict[int, list[Edge]] = defaultdict(list)
        dots: dict[int, list[Dot]] = defaultdict(list)
        for edge in self.scene.edges:
            edges[edge.picture].append(edge)
        for dot in self.scene.dots:
            dots[dot.picture].append(dot)
        for picture in sorted({*edges, *dots}):
            step = child(layer, "g")
            self._appear(step, picture)
            self._write_edges(step, edges[picture])
            self._write_dots(step, dots[picture])

    def _write_edges(self, step: ET.Element, edges: list[Edge]) -> None:
        for robot in sorted({edge.robot for edge in edges}):
            d = "".join(self.pen.line(edge.ends) for edge in edges if edge.robot == robot)
            child(step, "path", d=d, **styles_of(robot).edge.attributes(self.layout.mm))

    def _write_dots(self, step: ET.Element, dots: list[Dot]) -> None:
        mm, size_mm = self.layout.mm, self.scene.node_mm
        for robot in sorted({dot.robot for dot in dots}):
            own = [dot for dot in dots if dot.robot == robot]
            d = "".join(self.pen.marker(dot.marker, *dot.place, size_mm * mm) for dot in own)
            style = styles_of(robot).node.scaled(size_mm / NODE_MM[1])
            child(step, "path", d=d, **style.attributes(mm))

    def _write_goals(self) -> None:
        layer = child(self.map, "g", id="goals")
        mark = Pen(decimals=3).marker("diamond", 0.0, 0.0, GOAL_MM * self.layout.mm)
        for robot, actor in enumerate(self.scene.actors):
            if not any(goal.place for goal in actor.goals):
                continue
            # A goal stays where it was while it is hidden.
            style = goal_style(robot).attributes(self.layout.mm)
            goal = child(layer, "path", d=mark, **style)
            places = [g.place for g in actor.goals]
            first = next(place for place in places if place is not None)
            spots, shares, seen = [self._place(first)], [0.0], ["hidden"]
            for own in actor.goals:
                spots.append(spots[-1] if own.place is None else self._place(own.place))
                seen.append("hidden" if own.place is None else "visible")
                shares.append(self.pace.share_of(own.picture))
            goal.set("class", "shown" if places[-1] else "passing")
            set_attributes(goal, {"transform": f"translate({spots[-1]})", "visibility": seen[-1]})
            self._animate(goal, "visibility", seen, shares, calcMode="discrete")
            self._animate(goal, "transform", spots, shares, type="translate", calcMode="discrete")

    def _write_bodies(self) -> None:
        moving = child(self.map, "g", id="bodies", **{"class": "moving"})
        still = child(
            self.map, "g", id="bodies-at-the-end", **{"class": "still", "display": "none"}
        )
        for robot, actor in enumerate(self.scene.actors):
            self._write_body(moving, robot, actor, moves=True)
            self._write_body(still, robot, actor, moves=False)

    def _write_body(self, parent: ET.Element, robot: int, actor: Actor, *, moves: bool) -> None:
        mm, way = self.layout.mm, actor.way
        places = [self._place((x, y)) for x, y in way.places]
        turns = [_plain(turn, 1) for turn in np.degrees(way.headings)]
        group = child(parent, "g", transform=f"translate({places[-1]})")
        if moves:
            group.set("id", f"robot-{robot}")
            self._keyed(group, "transform", places, way.times_s, type="translate")
        self._write_ring(group, actor, moves=moves)
        turned = child(group, "g", transform=f"rotate({turns[-1]})")
        if moves:
            self._keyed(turned, "transform", turns, way.turn_times_s, type="rotate")
        self._write_shape(turned, actor, {"stroke": WHITE, "stroke-width": _plain(HALO_MM * mm)})
        body = self._write_shape(turned, actor, styles_of(robot).end.attributes(mm))
        front = child(turned, "path", d=f"M0 0H{_plain(actor.front_m)}")
        front.set("stroke-width", _plain(HEADING_MM * mm))
        fills = [body_fill(robot, span.shown) for span in actor.activities]
        headings = [heading_colour(fill) for fill in fills]
        for element, attribute, colours in ((body, "fill", fills), (front, "stroke", headings)):
            element.set(attribute, colours[-1])
            if moves:
                shares = [self.pace.share_of(span.begin) for span in actor.activities]
                self._animate(element, attribute, colours, shares, calcMode="discrete")
        if is_numbered(self.scene):
            self._write_label(group, str(robot), actor.outer_m)

    def _write_shape(
        self, parent: ET.Element, actor: Actor, attributes: Mapping[str, str]
    ) -> ET.Element:
        if actor.radius_m is None:
            fine = replace(self.pen, origin=(0.0, 0.0), decimals=self.pen.decimals + 1)
            shape = child(parent, "path", d=fine.rings([actor.outline]))
        else:
            shape = child(parent, "circle", r=_plain(actor.radius_m))
        set_attributes(shape, attributes)
        return shape

    def _write_ring(self, group: ET.Element, actor: Actor, *, moves: bool) -> None:
        seen = ["visible" if s.shown == "cut off" else "hidden" for s in actor.activities]
        if "visible" not in seen:
            return
        style = CUT_OFF_RING.attributes(self.layout.mm)
        ring = child(group, "circle", r=_plain(RING * actor.outer_m), visibility=seen[-1], **style)
        if moves:
            shares = [self.pace.share_of(span.begin) for span in actor.activities]
            self._animate(ring, "visibility", seen, shares, calcMode="discrete")

    def _write_label(self, group: ET.Element, text: str, outer: float) -> None:
        scale, size = self.layout.scale, self.layout.label_px
        away = _plain(label_place(outer, size / scale), 3)
        child(
            group,
            "text",
            text,
            transform=f"translate({away} {away}) scale({_plain(1 / scale)} {_plain(-1 / scale)})",
            y=_plain(0.36 * size),
            font_size=_plain(size),
            font_family=FONT,
            font_weight="bold",
            text_anchor="middle",
            fill=INK,
            stroke=WHITE,
            stroke_width=_plain(0.25 * size),
            paint_order="stroke",
        )

    def _keyed(
        self,
        element: ET.Element,
        attribute: str,
        values: Sequence[str],
        times_s: Iterable[float],
        **more: str,
    ) -> None:
        # Linear between the times; then the last value stays.
        shares = [self.pace.share(time_s) for time_s in times_s]
        self._animate(element, attribute, [*values, values[-1]], [*shares, 1.0], **more)

    def _place(self, place: tuple[float, float]) -> str:
        x, y = (
            _plain(value - origin, self.pen.decimals)
            for value, origin in zip(place, self.pen.origin, strict=True)
        )
        return f"{x} {y}"

    # The lines above and below the map. --------------------------------------------------

    def _write_text(
        self, parent: ET.Element, text: str, x: float, y: float, size: float, **more: str
    ) -> ET.Element:
        more = {"font_size": _plain(size), **more}
        return child(parent, "text", text, x=_plain(x), y=_plain(y + 0.36 * size), **more)

    def _write_title(self) -> None:
        layout = self.layout
        group = child(self.root, "g", id="title", font_family=FONT, fill=INK)
        title, speed = title_texts(self.scene)
        left, y = layout.map[0], layout.title_y
        self._write_text(group, title, left, y, layout.title_px, font_weight="bold")
        if speed:
            right = left + layout.map[2]
            self._write_text(group, speed, right, y, layout.text_px, text_anchor="end")

    def _write_time(self) -> None:
        unit, layout = self.layout.unit, self.layout
        group = child(self.root, "g", id="time", font_family=FONT, fill=INK)
        left, _, wide, _ = layout.map
        y = layout.caption_y + 0.5 * layout.row_px
        captions = self.scene.captions
        for span in captions:
            text = self._write_text(group, span.shown, left + wide, y, layout.text_px)
            text.set("text-anchor", "end")
            self._pass(text, span, last=span is captions[-1])
        bar = bar_width(self.scene)
        if not bar:
            return
        box = {
            "x": _plain(left),
            "y": _plain(y - BAR_PX * unit / 2),
            "height": _plain(BAR_PX * unit),
        }
        child(group, "rect", **box, width=_plain(bar), fill=TRACK)
        done = child(group, "rect", **box, width=_plain(bar), fill=PROGRESS)
        done.set("class", "bar")
        self._keyed(done, "width", ["0", _plain(bar)], (0.0, self.pace.run_s))

    def _write_list(self) -> None:
        layout = self.layout
        group = child(self.root, "g", id="robots", font_family=FONT, fill=INK)
        for robot, actor in enumerate(self.scene.actors):
            x, y = layout.entry(robot)
            side = layout.swatch_px
            box = {"x": _plain(x), "y": _plain(y - side / 2), "width": _plain(side)}
            fill = body_fill(robot, "moves")
            child(group, "rect", **box, height=_plain(side), fill=fill)
            for span in actor.activities:
                text = entry_text(robot, span.shown)
                element = self._write_text(group, text, x + 1.5 * side, y, layout.text_px)
                self._pass(element, span, last=span is actor.activities[-1])


def _plain(value: float, decimals: int = 4) -> str:
    return number(round(value * 10.0**decimals), decimals)
