"""Smaller SVG of figures: the same shapes and texts in a fraction of the bytes.

Matplotlib writes every mark as an element of its own with its whole style, and coordinates with
six decimals. Here styles are classes, marks of a series are one path, and coordinates have one
decimal.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final
from xml.sax.saxutils import escape

import numpy as np

from multisrt.drawing.svg import Pen
from multisrt.geometry.numerics.arrays import FloatArray

DECIMALS: Final = 1
"""Decimals of coordinates: figures are in points, and a tenth of one is not visible."""

PEN: Final = Pen(decimals=DECIMALS)

SVG: Final = "{http://www.w3.org/2000/svg}"
HREF: Final = "{http://www.w3.org/1999/xlink}href"

DEFAULTS: Final = {"text-anchor": "start", "stroke-dashoffset": "0", "stroke-linejoin": "round"}
"""Declarations that state what holds anyway; see the style of `*`."""

DOT_STYLES: Final = {"fill", "fill-opacity", "stroke", "stroke-width", "stroke-linejoin"}
"""Declarations of circles that can be drawn as dots."""

Style = Mapping[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Outline:
    """The shape of a path.

    Attributes
    ----------
    lines : list of (n, 2) array
        Its parts, if all of them are straight.
    closed : list of bool
        Whether each part is closed.
    data : str
        The path data as it was, for curves.
    """

    lines: list[FloatArray]
    closed: list[bool]
    data: str

    @property
    def curved(self) -> bool:
        """Whether the path has curves."""
        return bool(re.search("[CQ]", self.data))

    def moved(self, x: float, y: float) -> str:
        """Return its path data at another place."""
        if self.curved:
            return _shifted(self.data, x, y)
        move = np.array([x, y])
        return "".join(
            # A ring without an area is a line.
            (closed and PEN.rings([points + move])) or PEN.line(_thinned(points + move))
            for points, closed in zip(self.lines, self.closed, strict=True)
        )


@dataclass(slots=True, kw_only=True)
class Mark:
    """A path or a text with its style.

    Attributes
    ----------
    style : mapping of str to str
        Declarations.
    data : str
        Path data; empty for a text.
    text, place : str
        The text and the attributes that say where it is.
    """

    style: Style
    data: str = ""
    text: str = ""
    place: str = ""


@dataclass(slots=True)
class _Reader:
    """The marks of a drawing, in their order."""

    outlines: dict[str, Outline] = field(default_factory=dict)
    clips: dict[str, str] = field(default_factory=dict)
    marks: list[Mark] = field(default_factory=list)

    def read(self, root: ET.Element) -> None:
        for element in root.iter(f"{SVG}clipPath"):
            name = f"c{len(self.clips)}"
            rect = element.find(f"{SVG}rect")
            assert rect is not None
            x, y, width, height = (float(rect.get(a, "0")) for a in ("x", "y", "width", "height"))
            corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
            self.clips[f"url(#{element.get('id')})"] = (
                f"<clipPath id='{name}'><path d='{PEN.rings([corners])}'/></clipPath>"
            )
        for defs in root.iter(f"{SVG}defs"):
            for path in defs.iter(f"{SVG}path"):
                self.outlines[f"#{path.get('id')}"] = _outline(path.get("d", ""))
        self._inside(root, {})

    def _inside(self, parent: ET.Element, around: Style) -> None:
        own = {**around, **self._style(parent)} if parent.tag == f"{SVG}g" else around
        for element, uses in _series(parent):
            if uses:
                self._dots(uses, {**own, **self._style(element)})
            elif element.tag == f"{SVG}path":
                data = _outline(element.get("d", "")).moved(0.0, 0.0)
                self._add(Mark(style={**own, **self._style(element)}, data=data))
            elif element.tag == f"{SVG}text":
                self._add(_text({**own, **self._style(element)}, element))
            elif element.tag == f"{SVG}g":
                self._group(element, own)

    def _group(self, group: ET.Element, around: Style) -> None:
        # A group is moved if it has the lines of one text.
        if group.get("transform") is None:
            self._inside(group, around)
            return
        style = {**around, **self._style(group)}
        for element in group.iter(f"{SVG}text"):
            self._add(_text({**style, **self._style(element)}, element, group.get("transform")))

    def _dots(self, uses: list[ET.Element], style: Style) -> None:
        outline = self.outlines[uses[0].get(HREF, "")]
        places = np.array([(float(u.get("x", "0")), float(u.get("y", "0"))) for u in uses])
        radius = _radius(outline)
        if radius is not None and _is_plain_dot(style):
            edge = float(style.get("stroke-width", "1")) if "stroke" in style else 0.0
            self._add(Mark(style=_dot_style(style, 2 * radius + edge), data=_dotted(places)))
            return
        data = "".join(outline.moved(x, y) for x, y in places)
        self._add(Mark(style=style, data=data))

    def _add(self, mark: Mark) -> None:
        last = self.marks[-1] if self.marks else None
        joins = mark.data and mark.style.get("fill") == "none" and "stroke" in mark.style
        if last is not None and joins and last.data and last.style == mark.style:
            last.data += mark.data
        else:
            self.marks.append(mark)

    def _style(self, element: ET.Element) -> Style:
        pairs = re.findall(r"([\w-]+): *([^;]+)", element.get("style", ""))
        found = {name: value for name, value in pairs if DEFAULTS.get(name) != value}
        if (clip := element.get("clip-path")) is not None:
            found["clip-path"] = f"url(#c{list(self.clips).index(clip)})"
        return found


def compact(svg: bytes) -> bytes:
    """Return a figure of matplotlib as a smaller SVG that looks the same.

    Parameters
    ----------
    svg : bytes
        The figure, with texts as texts.

    Returns
    -------
    bytes
        The smaller SVG. Attributes are in single quotes, so that few bytes must be escaped where
        it is embedded in a page.
    """
    root = ET.fromstring(svg)
    reader = _Reader()
    reader.read(root)
    family = next((m.style["font-family"] for m in reader.marks if "font-family" in m.style), "")
    classes: dict[str, str] = {}
    body = "".join(_written(mark, classes, family) for mark in reader.marks)
    rules = "".join(f".{name}{{{style}}}" for style, name in classes.items())
    title = escape(root.findtext(f"{SVG}title", ""))
    _, _, width, height = root.get("viewBox", "0 0 0 0").split()
    w, h = (f"{float(side):.{DECIMALS}f}" for side in (width, height))
    return (
        f"<svg xmlns='http://www.w3.org/2000/svg' width='{w}pt' height='{h}pt' "
        f"viewBox='0 0 {w} {h}'><title>{title}</title>"
        f"<style>*{{stroke-linejoin:round}}text{{font-family:{family}}}{rules}</style>"
        f"{''.join(reader.clips.values())}{body}</svg>\n"
    ).encode()


def _written(mark: Mark, classes: dict[str, str], family: str) -> str:
    declared = {k: v for k, v in mark.style.items() if (k, v) != ("font-family", family)}
    style = ";".join(f"{name}:{value}" for name, value in declared.items())
    name = classes.setdefault(style, _class_name(len(classes)))
    if mark.data:
        return f"<path class='{name}' d='{mark.data}'/>"
    return f"<text class='{name}'{mark.place}>{escape(mark.text)}</text>"


def _class_name(number: int) -> str:
    letters = "abcdefghijklmnopqrstuvwxyz"
    return letters[number % 26] + (str(number // 26) if number >= 26 else "")


def _series(parent: ET.Element) -> Iterator[tuple[ET.Element, list[ET.Element]]]:
    """Yield the elements of a group; those of the same mark in a row come with all of them."""
    waiting: list[ET.Element] = []
    for element in parent:
        if element.tag == f"{SVG}use":
            key = (element.get(HREF), element.get("style"))
            if waiting and key != (waiting[0].get(HREF), waiting[0].get("style")):
                yield waiting[0], waiting
                waiting = []
            waiting.append(element)
            continue
        if waiting:
            yield waiting[0], waiting
            waiting = []
        yield element, []
    if waiting:
        yield waiting[0], waiting


def _text(style: Style, element: ET.Element, moved: str | None = None) -> Mark:
    x, y = (float(element.get(name, "0")) for name in ("x", "y"))
    place = f" x='{_short(x)}' y='{_short(y)}'"
    turned = element.get("transform", "")
    turns = [t for t in (moved or "", turned) if not re.match(r"rotate\(-?0(\.0*)?[ )]", t)]
    if transform := " ".join(t for t in turns if t):
        place += f" transform='{re.sub(r'-?[0-9]+[.][0-9]+', _rounded, transform)}'"
    return Mark(style=style, text="".join(element.itertext()), place=place)


def _outline(data: str) -> Outline:
    lines, closed = [], []
    for part in re.findall(r"M[^M]*", data):
        values = [float(word) for word in re.findall(r"-?[\d.]+(?:e-?\d+)?", part)]
        lines.append(np.array(values).reshape(-1, 2))
        closed.append("z" in part)
    return Outline(lines=lines, closed=closed, data=data)


def _shifted(data: str, x: float, y: float) -> str:
    # All commands are absolute and take pairs of numbers.
    text = []
    for command, words in re.findall(r"([MLCQz])([^MLCQz]*)", data):
        places = np.array([float(word) for word in words.split()]).reshape(-1, 2)
        places += np.array([x, y])
        text.append(command + " ".join(_short(value) for value in places.ravel().tolist()))
    return "".join(text)


def _radius(outline: Outline) -> float | None:
    """Return the radius of a circle about the origin; None for any other shape."""
    if outline.data.count("C") != 8 or len(outline.lines) != 1:
        return None
    low, high = outline.lines[0].min(axis=0), outline.lines[0].max(axis=0)
    sides = np.abs(np.concatenate([low, high]))
    return float(sides[0]) if np.allclose(sides, sides[0], rtol=1e-3) else None


def _is_plain_dot(style: Style) -> bool:
    # Of one colour; an edge that shines through where the inside does not is not of one.
    fill, stroke = style.get("fill", "none"), style.get("stroke")
    own = style.keys() - {"clip-path"}
    return fill != "none" and own <= DOT_STYLES and (stroke is None or stroke == fill)


def _dot_style(style: Style, width: float) -> Style:
    kept = {name: style[name] for name in ("clip-path",) if name in style}
    if "fill-opacity" in style:
        kept["stroke-opacity"] = style["fill-opacity"]
    dot = {"fill": "none", "stroke": style["fill"], "stroke-width": f"{width:.3g}"}
    return {**kept, **dot, "stroke-linecap": "round"}


def _dotted(places: FloatArray) -> str:
    # Lines without a length, whose round ends make the dots.
    steps = np.rint(places * 10**DECIMALS) / 10**DECIMALS
    moves = np.diff(steps, axis=0, prepend=np.zeros((1, 2)))
    first, *others = [PEN.line([move]).removeprefix("M") for move in moves]
    return f"M{first}h0" + "".join(f"m{text}h0" for text in others)


def _thinned(points: FloatArray) -> FloatArray:
    """Return a line without the points that lie, as rounded, on the way between others."""
    steps: FloatArray = np.rint(points * 10**DECIMALS)
    steps = steps[np.concatenate([[True], np.diff(steps, axis=0).any(axis=1)])]
    if len(steps) > 2:
        before, after = np.diff(steps[:-1], axis=0), np.diff(steps[1:], axis=0)
        turns = before[:, 0] * after[:, 1] != before[:, 1] * after[:, 0]
        back = (before * after).sum(axis=1) < 0.0
        steps = steps[np.concatenate([[True], turns | back, [True]])]
    return steps / 10**DECIMALS


def _rounded(found: re.Match[str]) -> str:
    return _short(float(found[0]))


def _short(value: float) -> str:
    text = f"{value:.{DECIMALS}f}"
    return text.rstrip("0").rstrip(".")
