"""The shapes of an SVG document that are drawn, with what they inherit from groups."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from multisrt.environments.formats.plan import Role, role_of, role_within
from multisrt.environments.formats.svg.lengths import (
    MAX_NUMBER,
    SvgError,
    fitted,
    length,
    matrix,
    numbers,
)
from multisrt.environments.formats.svg.styles import INITIAL, StyleSheet, opacity
from multisrt.environments.formats.xml_text import MAX_DEPTH, Element
from multisrt.geometry.errors import MapFormatError, shortened, shown
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import FloatArray

SVG_NAMESPACE: Final = "http://www.w3.org/2000/svg"
LABEL: Final = "http://www.inkscape.org/namespaces/inkscape label"
GROUP_MODE: Final = "http://www.inkscape.org/namespaces/inkscape groupmode"
HREFS: Final = ("href", "http://www.w3.org/1999/xlink href")

MAX_DRAWN: Final = 25_000
"""Upper bound of the elements that are drawn; those in symbols count once for each use."""

MAX_CHARACTERS: Final = 6 * 2**20
"""Upper bound of the characters in their attributes, counted in the same way."""

SHAPES: Final = frozenset({"path", "rect", "circle", "ellipse", "line", "polyline", "polygon"})
GROUPS: Final = frozenset({"g", "a", "svg", "switch"})


class Clip(NamedTuple):
    """A ``clipPath`` element and the transform from its user space."""

    element: Element
    matrix: FloatArray
    style: dict[str, str]


class Drawn(NamedTuple):
    """A shape (or image) that is drawn.

    Attributes
    ----------
    element : Element
        The shape.
    matrix : float array, shape (3, 3)
        Transform from its user space.
    style : dict of str to str
        Its properties.
    opacity : float
        Opacity of the shape and of all groups around it.
    role : Role or None
        Role by its own names, or else by those of the nearest group that has one.
    clips : tuple of Clip
        The clip paths that apply to it.
    viewport : (width, height)
        Size to which lengths in per cent refer, in user units.
    named : str
        The name that gives it its role; empty if it has none.
    layer : str
        Name of the nearest layer of Inkscape, or else of the outermost group that has a name;
        may be empty.
    """

    element: Element
    matrix: FloatArray
    style: dict[str, str]
    opacity: float
    role: Role | None
    clips: tuple[Clip, ...]
    viewport: tuple[float, float]
    named: str
    layer: str


class _Context(NamedTuple):
    matrix: FloatArray
    style: dict[str, str]
    opacity: float
    role: Role | None
    clips: tuple[Clip, ...]
    viewport: tuple[float, float]
    named: str
    layer: str
    depth: int


class Document:
    """An SVG document.

    Parameters
    ----------
    path : Path
        The file, for messages.
    root : Element
        Its root.

    Raises
    ------
    MapFormatError
        If the root is not ``svg``, or its style sheets are not understood.
    """

    def __init__(self, path: Path, root: Element) -> None:
        if root.name != "svg" or not is_svg(root):
            raise MapFormatError(
                f"{path} has the root {shortened(root.name)}; the root of SVG is svg"
            )
        self.path = path
        self.root = root
        elements = [one for one in _all_elements(root) if is_svg(one)]
        self.by_id = {one.attributes["id"]: one for one in elements if "id" in one.attributes}
        self._sheet = StyleSheet(path, [one for one in elements if one.name == "style"])
        self._count = self._characters = 0

    def wrong(self, element: Element, what: object) -> MapFormatError:
        """Return an error about an element, with its line."""
        return MapFormatError(f"{self.place(element)}: {what}")

    def place(self, element: Element) -> str:
        """Return where an element is: the file and its line."""
        return f"{self.path}, line {element.line}, <{shortened(element.name)}>"

    def drawn(
        self, element: Element, transform: FloatArray, viewport: tuple[float, float]
    ) -> Iterator[Drawn]:
        """Yield the shapes in an element that are drawn, in drawing order.

        Parameters
        ----------
        element : Element
            A group, or the root, whose own transform and view box are not applied.
        transform : float array, shape (3, 3)
            Transform from its user space.
        viewport : (width, height)
            Size of its viewport, in user units.

        Raises
        ------
        MapFormatError
            If an attribute is wrong, a reference has no target or leads out of the file, or too
            much is drawn.
        """
        try:
            style = self._sheet.computed(element, INITIAL)
        except SvgError as error:
            raise self.wrong(element, error) from error
        shown = opacity(style["opacity"])
        context = _Context(transform, style, shown, None, (), viewport, "", "", 0)
        if style["display"] != "none":
            for child in element.children:
                yield from self._drawn(child, context)

    def _drawn(self, element: Element, around: _Context) -> Iterator[Drawn]:
        if not is_svg(element) or not (
            element.name in SHAPES or element.name in GROUPS or element.name in ("use", "image")
        ):
            return
        self._count += 1
        if self._count > MAX_DRAWN:
            raise self.wrong(element, f"more than {MAX_DRAWN:,} elements are drawn; simplify it")
        self._characters += sum(map(len, element.attributes.values()))
        if self._characters > MAX_CHARACTERS:
            raise self.wrong(
                element,
                f"what is drawn has more than {MAX_CHARACTERS:,} characters, counting symbols once "
                "for each use; simplify it",
            )
        if around.depth > MAX_DEPTH:
            raise self.wrong(element, f"groups and uses are nested more than {MAX_DEPTH} deep")
        try:
            context = self._context_in(element, around)
            if context is None:
                return
            if element.name == "use":
                target, context = self._use_target(element, context)
                children = [target]
                if target.name == "symbol":
                    context = self._in_symbol(target, context)
                    children = target.children
            else:
                if element.name == "svg":
                    context = self._in_svg(element, context)
                children = element.children if element.name in GROUPS else []
        except SvgError as error:
            raise self.wrong(element, error) from error
        if element.name in SHAPES or element.name == "image":
            if context.style["visibility"] == "visible":
                yield Drawn(element, *context[:-1])
            return
        for child in children:
            yield from self._drawn(child, context)

    def _context_in(self, element: Element, around: _Context) -> _Context | None:
        """Return the context in an element; None if it is not displayed."""
        style = self._sheet.computed(element, around.style)
        if style["display"] == "none":
            return None
        own = matrix(element.attributes.get("transform", ""))
        context = around._replace(
            matrix=_product(around.matrix, own),
            style=style,
            opacity=around.opacity * opacity(style["opacity"]),
            layer=_layer(element, around.layer),
            depth=around.depth + 1,
        )._replace(**_role(element, around))
        if style["mask"] != "none":
            raise SvgError("masks are not read; cut the shape itself")
        if style["clip-path"] != "none":
            target = self._referred(style["clip-path"].removeprefix("url(").rstrip(") "))
            if target.name != "clipPath":
                raise SvgError(f"the clip-path {shown(style['clip-path'])} is not a clipPath")
            if target.attributes.get("clipPathUnits", "userSpaceOnUse") != "userSpaceOnUse":
                raise SvgError("a clipPath in units of the bounding box is not read")
            clip = Clip(target, context.matrix, style)
            context = context._replace(clips=(*context.clips, clip))
        return context

    def _use_target(self, use: Element, context: _Context) -> tuple[Element, _Context]:
        """Return the element that a ``use`` element draws, and its context."""
        href = next((use.attributes[name] for name in HREFS if name in use.attributes), "")
        target = self._referred(href)
        x, y = (
            length(use.attributes.get(name, "0"), whole)
            for name, whole in zip("xy", context.viewport, strict=True)
        )
        moved = np.array([[1, 0, x], [0, 1, y], [0, 0, 1.0]])
        context = context._replace(matrix=_product(context.matrix, moved))
        if target.name in ("symbol", "svg"):
            width, height = (
                use.attributes.get(name, target.attributes.get(name, "100%"))
                for name in ("width", "height")
            )
            if target.name == "symbol":
                context = self._with_viewport(target, context, width, height)
            else:
                sized = target.attributes | {"width": width, "height": height}
                target = Element("svg", SVG_NAMESPACE, sized, target.line, target.children)
        return target, context

    def _in_symbol(self, symbol: Element, context: _Context) -> _Context:
        style = self._sheet.computed(symbol, context.style)
        return context._replace(
            style=style,
            opacity=context.opacity * opacity(style["opacity"]),
        )._replace(**_role(symbol, context))

    def _referred(self, href: str) -> Element:
        name = href.strip("\"' ")
        if not name.startswith("#"):
            raise SvgError(f"{shown(name)} is in another file; draw it in this one")
        target = self.by_id.get(name[1:])
        if target is None:
            raise SvgError(f"there is no {shown(name)} in the file")
        return target

    def _in_svg(self, element: Element, context: _Context) -> _Context:
        attributes = element.attributes
        x, y = (
            length(attributes.get(name, "0"), whole)
            for name, whole in zip("xy", context.viewport, strict=True)
        )
        moved = np.array([[1, 0, x], [0, 1, y], [0, 0, 1.0]])
        context = context._replace(matrix=_product(context.matrix, moved))
        width, height = (attributes.get(name, "100%") for name in ("width", "height"))
        return self._with_viewport(element, context, width, height)

    def _with_viewport(
        self, element: Element, context: _Context, width: str, height: str
    ) -> _Context:
        """Return the context in an element with a viewport of that size."""
        w, h = (
            length(one, whole) for one, whole in zip((width, height), context.viewport, strict=True)
        )
        box = view_box(element)
        if box is None:
            return context._replace(viewport=(w, h))
        aspect = element.attributes.get("preserveAspectRatio", "xMidYMid meet")
        inner = fitted(box, max(w, 0.0), max(h, 0.0), aspect)
        return context._replace(matrix=_product(context.matrix, inner), viewport=box[2:])


def is_svg(element: Element) -> bool:
    """Return whether an element is of SVG; elements without a namespace count as such."""
    return element.namespace in ("", SVG_NAMESPACE)


def view_box(element: Element) -> tuple[float, float, float, float] | None:
    """Return the view box of an element; None if it has none."""
    text = element.attributes.get("viewBox")
    if text is None:
        return None
    values = numbers(text)
    if len(values) != 4 or not (values[2] > 0 and values[3] > 0):
        raise SvgError(f"viewBox {shown(text)} is not x, y, width and height, both positive")
    x, y, width, height = values
    return x, y, width, height


def _role(element: Element, around: _Context) -> dict[str, Any]:
    """Return the role of an element, and the name that gives it."""
    label = element.attributes.get(LABEL, "")
    names = [*element.attributes.get("class", "").split(), element.attributes.get("id", "")]
    if role_of([label]):
        names = [label]
    role = role_within(names, around.role)
    if role is around.role:
        return {}
    return {"role": role, "named": next(name for name in names if role_of([name]) is role)}


def _layer(element: Element, around: str) -> str:
    if element.name not in GROUPS or (around and element.attributes.get(GROUP_MODE) != "layer"):
        return around
    return element.attributes.get(LABEL, "") or element.attributes.get("id", "") or around


def _product(outer: FloatArray, inner: FloatArray) -> FloatArray:
    product = libm.product(outer, inner)
    if not np.abs(product).max() <= MAX_NUMBER:
        raise SvgError(f"the transform is beyond {MAX_NUMBER:g}")
    return product


def _all_elements(root: Element) -> Iterator[Element]:
    waiting = [root]
    while waiting:
        element = waiting.pop()
        yield element
        waiting.extend(reversed(element.children))
