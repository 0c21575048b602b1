"""Properties of elements: presentation attributes, simple rules of style sheets, style=""."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final, NamedTuple

from multisrt.environments.formats.svg.lengths import SvgError, number
from multisrt.environments.formats.xml_text import Element
from multisrt.geometry.errors import MapFormatError, shown

INITIAL: Final = {
    "clip-rule": "nonzero",
    "color": "black",
    "fill": "black",
    "fill-opacity": "1",
    "fill-rule": "nonzero",
    "stroke": "none",
    "stroke-dasharray": "none",
    "stroke-linecap": "butt",
    "stroke-linejoin": "miter",
    "stroke-miterlimit": "4",
    "stroke-opacity": "1",
    "stroke-width": "1",
    "visibility": "visible",
}
"""Properties that children inherit, with their initial values."""

OWN: Final = {
    "clip-path": "none",
    "display": "inline",
    "mask": "none",
    "opacity": "1",
    "vector-effect": "none",
}
"""Properties that concern an element itself, with their initial values."""

MAX_STYLE_CHARACTERS: Final = 2**20
"""Upper bound of the length of a style sheet, in characters."""

MAX_RULES: Final = 2_000
"""Upper bound of the rules of style sheets."""

MAX_MATCHES: Final = 5_000_000
"""Upper bound of the number of times that a rule is tried on an element."""

_PROPERTIES: Final = INITIAL.keys() | OWN.keys()
_SIMPLE: Final = re.compile(r"(\*|[\w-]+)?((?:[.#][\w-]+)*)\Z")


class _Rule(NamedTuple):
    tag: str
    classes: frozenset[str]
    ids: frozenset[str]
    normal: dict[str, str]
    important: dict[str, str]


class StyleSheet:
    """The rules of the ``style`` elements of a document.

    Parameters
    ----------
    path : Path
        The file, for messages.
    sheets : iterable of Element
        The ``style`` elements. Selectors of an element, classes and an identifier are supported
        (``rect``, ``.wall``, ``g.wall``, ``#outline``, ``*``). Rules with pseudo-classes
        (``:hover``) and at-rules (``@media``) are ignored.

    Raises
    ------
    MapFormatError
        If a rule for a supported property has another selector.
    """

    def __init__(self, path: Path, sheets: list[Element]) -> None:
        self._path = path
        self._rules: list[_Rule] = []
        self._tried = 0
        for sheet in sheets:
            self._read(sheet)
        # The sort is stable: of two equally specific rules, the later counts.
        self._rules.sort(key=lambda r: (len(r.ids), len(r.classes), r.tag not in ("", "*")))

    def _read(self, sheet: Element) -> None:
        if len(sheet.text) > MAX_STYLE_CHARACTERS:
            raise MapFormatError(
                f"{self._path}, line {sheet.line}: a style sheet has {len(sheet.text):,} "
                f"characters; they are read up to {MAX_STYLE_CHARACTERS:,}"
            )
        for rule in _without_at_rules(_without_comments(sheet.text)).split("}"):
            selectors, _, body = rule.partition("{")
            try:
                normal, important = declarations(body)
            except SvgError as error:
                raise MapFormatError(f"{self._path}, line {sheet.line}: {error}") from error
            if not normal and not important:
                continue
            for selector in (one.strip() for one in selectors.split(",")):
                if ":" in selector:
                    continue
                found = _SIMPLE.match(selector)
                if found is None or not selector:
                    raise MapFormatError(
                        f"{self._path}, line {sheet.line}: the style rule for {shown(selector)} is "
                        "not one of an element, a class or an identifier; save the drawing as "
                        "plain SVG, with attributes in place of rules"
                    )
                names = re.findall(r"[.#][\w-]+", found.group(2))
                self._rules.append(
                    _Rule(
                        found.group(1) or "",
                        frozenset(name[1:] for name in names if name[0] == "."),
                        frozenset(name[1:] for name in names if name[0] == "#"),
                        normal,
                        important,
                    )
                )
            if len(self._rules) > MAX_RULES:
                raise MapFormatError(f"{self._path} has more than {MAX_RULES:,} style rules")

    def computed(self, element: Element, inherited: Mapping[str, str]) -> dict[str, str]:
        """Return the properties of an element.

        Parameters
        ----------
        element : Element
            The element.
        inherited : mapping of str to str
            Properties of its parent.

        Raises
        ------
        MapFormatError
            If rules would be tried too often.
        """
        attributes = element.attributes
        given = {name: attributes[name] for name in _PROPERTIES & attributes.keys()}
        late: dict[str, str] = {}
        if self._rules:
            self._tried += len(self._rules)
            if self._tried > MAX_MATCHES:
                raise MapFormatError(f"{self._path} has too many style rules for its elements")
            classes = set(attributes.get("class", "").split())
            name = attributes.get("id", "")
            for rule in self._rules:
                if (
                    rule.tag in ("", "*", element.name)
                    and rule.classes <= classes
                    and rule.ids <= {name}
                ):
                    given |= rule.normal
                    late |= rule.important
        if "style" in attributes:
            normal, important = declarations(attributes["style"])
            given |= normal
            late |= important
        given |= late
        result = {name: inherited.get(name, start) for name, start in INITIAL.items()} | OWN
        for name, value in given.items():
            value = value.strip()
            if value == "inherit":
                value = inherited.get(name, (INITIAL | OWN)[name])
            elif value == "initial":
                value = (INITIAL | OWN)[name]
            result[name] = value
        return result


def _without_comments(text: str) -> str:
    kept, at = [], 0
    while (start := text.find("/*", at)) >= 0:
        kept.append(text[at:start])
        end = text.find("*/", start + 2)
        at = len(text) if end < 0 else end + 2
    return "".join((*kept, text[at:])).replace("<!--", " ").replace("-->", " ")


def _without_at_rules(text: str) -> str:
    """Return a style sheet without ``@media {...}`` and the like, and without ``@import ...;``."""
    kept, at = [], 0
    while (start := text.find("@", at)) >= 0:
        kept.append(text[at:start])
        depth, at = 0, start
        while at < len(text):
            sign = text[at]
            at += 1
            depth += (sign == "{") - (sign == "}")
            if (sign == ";" and depth == 0) or (sign == "}" and depth <= 0):
                break
    return "".join(kept) + text[at:]


def declarations(body: str) -> tuple[dict[str, str], dict[str, str]]:
    """Return the supported properties of a text ``name: value; ...``, and the important ones.

    Examples
    --------
    >>> declarations("fill: #fff; stroke:red !important; font-size: 12px")
    ({'fill': '#fff'}, {'stroke': 'red'})
    """
    normal: dict[str, str] = {}
    important: dict[str, str] = {}
    for one in body.split(";"):
        name, colon, value = one.partition(":")
        name = name.strip().lower()
        if colon and name == "transform" and value.strip() != "none":
            raise SvgError("a transform in a style is not read; give it as an attribute")
        if colon and name in _PROPERTIES:
            value, mark, _ = value.partition("!")
            (important if mark else normal)[name] = value.strip()
    return normal, important


def opacity(text: str) -> float:
    """Return an opacity in [0, 1], given as a number or in per cent."""
    value = number(text[:-1]) / 100 if text.endswith("%") else number(text)
    return min(max(value, 0.0), 1.0)


def lightness_and_alpha(paint: str, color: str) -> tuple[float, float] | None:
    """Return the lightness of a paint in [0, 1] and its opacity; None if nothing is painted.

    Lightness is the luma, as in images.

    Parameters
    ----------
    paint : str
        The value of ``fill`` or ``stroke``.
    color : str
        The value of ``currentColor``.

    Raises
    ------
    SvgError
        If it is not a plain colour.

    Examples
    --------
    >>> lightness_and_alpha("#ffffff", "black"), lightness_and_alpha("none", "black")
    ((1.0, 1.0), None)
    """
    from PIL import ImageColor

    paint = paint.strip()
    if paint.lower() == "currentcolor":
        paint = color.strip()
    if paint.lower() in ("none", "transparent"):
        return None
    alpha = 1.0
    # Pillow takes no share as the alpha of rgba: split it off, and parse the rest as rgb.
    found = re.fullmatch(
        r"(rgb|hsl)a?\(([^,()]+),([^,()]+),([^,()]+)(?:,([^,()]+))?\)", paint, re.IGNORECASE
    )
    text = paint
    if found:
        kind, *channels, share = found.groups()
        text = f"{kind.lower()}({','.join(one.strip() for one in channels)})"
        alpha = opacity(share.strip()) if share else 1.0
    try:
        red, green, blue, *rest = ImageColor.getrgb(text[:100])
    except (ValueError, OverflowError) as error:
        raise SvgError(
            f"the paint {shown(paint)} is not a plain colour such as #404040; give it one, or "
            "name the layers of walls and free space"
        ) from error
    if rest:
        alpha *= rest[0] / 255
    clipped = [min(max(one, 0), 255) for one in (red, green, blue)]
    luma = (299 * clipped[0] + 587 * clipped[1] + 114 * clipped[2]) / 255_000
    return luma, alpha
