"""Styles of pictures, which are readable in grey and without telling red from green.

Colour alone carries no information: lines also differ in width and dashes, nodes in shape.
Source of most colours: Okabe and Ito, Color Universal Design, 2008.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Final

from multisrt.drawing.svg import Marker, plain
from multisrt.events import ArcReason, Stage

WHITE: Final = "#ffffff"
INK: Final = "#1a1a1a"
ANY_ROBOT: Final = "#5c5c5c"
VERMILION: Final = "#b94600"
"""Darker than in the source, so that it also stands out in grey."""


ROBOT_COLOURS: Final = (
    "#0072b2",  # blue
    "#e69f00",  # orange
    "#009e73",  # bluish green
    "#cc79a7",  # reddish purple
    "#a8a000",  # olive
    "#56b4e9",  # sky blue
    "#8a5a2b",  # brown
    "#7a68d8",  # violet
)
"""Colours of robots, by number. Vermilion is for the frontier, black and grey for the world."""

ROBOT_DASHES_MM: Final[tuple[tuple[float, ...], ...]] = (
    (),
    (1.6, 0.6),
    (0.5, 0.5),
    (1.8, 0.5, 0.4, 0.5),
    (3.2, 0.8),
    (0.9, 0.9),
    (3.0, 0.5, 0.4, 0.5, 0.4, 0.5),
    (2.4, 0.6, 0.8, 0.6),
)
"""Dashes of robots' trees, by number; shifted by one each time the colours repeat."""

SHADES: Final = ((0.0, 0.0, 0.36), (0.55, 0.12, 0.58), (0.0, 0.0, 0.16), (0.55, 0.5, 0.3))
"""Shares of black in the colours of lines and areas, and strength of the tint of areas.

The next entry is used each time the colours repeat."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Style:
    """Fill and stroke of a shape, with lengths in millimetres on paper.

    Attributes
    ----------
    fill, stroke : str or None
        Colours as ``#rrggbb``; None for no fill or stroke.
    fill_opacity, stroke_opacity : float
        Opacities from 0 to 1.
    width_mm : float
        Width of the stroke.
    dashes_mm : tuple of float
        Lengths of dashes and gaps in turn; empty for a solid line.
    """

    fill: str | None = None
    stroke: str | None = None
    fill_opacity: float = 1.0
    stroke_opacity: float = 1.0
    width_mm: float = 0.2
    dashes_mm: tuple[float, ...] = ()

    def attributes(self, mm: float) -> dict[str, str]:
        """Return the SVG attributes, for `mm` user units per millimetre on paper."""
        found = {"fill": self.fill or "none"}
        if self.fill and self.fill_opacity < 1.0:
            found["fill-opacity"] = f"{self.fill_opacity:g}"
        if self.stroke:
            found["stroke"] = self.stroke
            found["stroke-width"] = plain(self.width_mm * mm)
            found["stroke-linejoin"] = "round"
            found["stroke-linecap"] = "butt" if self.dashes_mm else "round"
            if self.stroke_opacity < 1.0:
                found["stroke-opacity"] = f"{self.stroke_opacity:g}"
            if self.dashes_mm:
                found["stroke-dasharray"] = " ".join(plain(d * mm) for d in self.dashes_mm)
        return found

    def scaled(self, factor: float) -> Style:
        """Return the style with width and dashes of the stroke multiplied by a factor."""
        dashes = tuple(factor * length for length in self.dashes_mm)
        return replace(self, width_mm=factor * self.width_mm, dashes_mm=dashes)


OBSTACLE: Final = Style(fill="#a3a3a3", stroke=INK, width_mm=0.18)
FREE: Final = Style(fill=WHITE)
FREE_SAMPLE: Final = Style(fill=WHITE, stroke=INK, width_mm=0.18)
FRONTIER: Final = Style(stroke=VERMILION, width_mm=0.9)
FRONTIER_CELLS: Final = Style(fill=VERMILION, stroke=VERMILION, width_mm=0.3)
KNOWN: Final = Style(stroke=INK, width_mm=0.14)
"""Border of the area that the team knows."""

CUT_OFF: Final = Style(stroke="#e8a17f", width_mm=1.5, dashes_mm=(0.9, 0.6))
"""Underlay of the path of an isolated robot: vermilion, mixed with white."""

START: Final = Style(fill=WHITE, stroke=INK, width_mm=0.35)
END: Final = Style(fill=INK, stroke=WHITE, width_mm=0.25)
SUGGESTED_START: Final = Style(fill=WHITE, stroke=INK, width_mm=0.35)
LATE_START: Final = Style(fill="#c9c9c9", stroke=INK, width_mm=0.35)
COLLISION: Final = Style(stroke=VERMILION, width_mm=0.8)
DEATH: Final = Style(stroke=INK, width_mm=0.9)
HALO: Final = Style(stroke=WHITE, width_mm=2.0)
"""Underlay of a cross, which separates it from lines."""

BASE: Final = Style(fill=INK, stroke=WHITE, width_mm=0.25)
DELIVERED: Final = Style(stroke=INK, width_mm=0.5, dashes_mm=(1.0, 0.8))
"""Border of the area that the base station knows."""

STOP: Final = Style(fill=WHITE, stroke=INK, width_mm=0.25)

CLOSED: Final[dict[ArcReason, Style]] = {
    "too narrow": Style(stroke=INK, width_mm=0.7, dashes_mm=(0.4, 0.35)),
    "not reachable": Style(stroke=INK, width_mm=0.7, dashes_mm=(1.4, 0.5)),
    "seen from near": Style(stroke=INK, width_mm=0.7, dashes_mm=(1.4, 0.4, 0.4, 0.4)),
    "blocked by a robot": Style(stroke=INK, width_mm=0.7, dashes_mm=(2.6, 0.4, 0.4, 0.4)),
}
"""Arcs of frontier that were given up, by reason."""


NODE_MM: Final = (0.3, 0.8)
"""Range of the radius of nodes, which are smaller where edges are short."""

START_MM: Final = 2.0
BASE_MM: Final = 2.0
GOAL_MM: Final = 0.6
END_MM: Final = 1.7
STOP_MM: Final = 0.9
DEATH_MM: Final = 1.5

STAGE_MARKERS: Final[dict[Stage, Marker]] = {
    "root": "square",
    "draw": "disc",
    "approach": "triangle",
    "complete": "diamond",
    "bypass": "wedge",
    "coordinate": "star",
}
"""Markers of nodes, by the stage that found their places."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotStyles:
    """Styles of the things that belong to one robot.

    Attributes
    ----------
    region, outline : Style
        Local safe region of a single robot, and of a robot in a team.
    area : Style
        Area that a robot in a team saw first. Areas do not overlap, so that colours never mix.
    path, team_path : Style
        Path of a single robot, and of a robot in a team.
    support, bridge : Style
        Path in support of other robots, and paths between nodes that no edge joins.
    edge, node : Style
        Edges and nodes of its tree.
    start, late_start, end : Style
        Start, late start and last configuration of a robot in a team.
    """

    region: Style
    outline: Style
    area: Style
    path: Style
    team_path: Style
    support: Style
    bridge: Style
    edge: Style
    node: Style
    start: Style
    late_start: Style
    end: Style

    @classmethod
    def of(cls, robot: int) -> RobotStyles:
        """Return the styles of a robot by its number; they repeat after 64 robots."""
        turn, number = divmod(robot, len(ROBOT_COLOURS))
        black, of_area, strength = SHADES[turn % len(SHADES)]
        colour = ROBOT_COLOURS[number]
        dashes = ROBOT_DASHES_MM[(number + turn) % len(ROBOT_DASHES_MM)]
        fill = tint(shade(colour, of_area), strength)
        return cls._in(shade(colour, black), fill, dashes)

    @classmethod
    def of_any(cls) -> RobotStyles:
        """Return the styles of samples in the legend of a team."""
        return cls._in(ANY_ROBOT, tint(ANY_ROBOT, SHADES[0][2]), ())

    @classmethod
    def _in(cls, colour: str, fill: str, dashes: tuple[float, ...]) -> RobotStyles:
        return cls(
            # Overlapping regions add up to the fill, which is therefore light.
            region=Style(
                fill=fill,
                fill_opacity=0.65,
                stroke=colour,
                stroke_opacity=0.45,
                width_mm=0.09,
            ),
            outline=Style(stroke=colour, stroke_opacity=0.4, width_mm=0.09),
            area=Style(fill=fill, stroke=colour, width_mm=0.18),
            path=Style(stroke=INK, width_mm=0.14, dashes_mm=(0.5, 0.4)),
            team_path=Style(stroke=colour, width_mm=0.16, dashes_mm=(0.5, 0.4)),
            # Opaque, so that paths of several robots on one line do not mix their colours.
            support=Style(stroke=tint(colour, 0.72), width_mm=1.0, dashes_mm=(1.1, 0.9)),
            bridge=Style(stroke=colour, width_mm=0.22),
            edge=Style(stroke=colour, width_mm=0.4, dashes_mm=dashes),
            node=Style(fill=colour, stroke=WHITE, width_mm=0.12),
            start=Style(fill=WHITE, stroke=colour, width_mm=0.45),
            late_start=Style(fill=LATE_START.fill, stroke=colour, width_mm=0.45),
            end=Style(fill=colour, stroke=INK, width_mm=0.18),
        )


def shade(colour: str, black: float) -> str:
    """Return a colour, ``#rrggbb``, mixed with a share of black from 0 to 1."""
    return _hex((1.0 - black) * channel for channel in channels(colour))


def tint(colour: str, strength: float) -> str:
    """Return a colour mixed with white.

    Parameters
    ----------
    colour : str
        The colour, as ``#rrggbb``.
    strength : float
        Share of the colour, from 0 (white) to 1.

    Returns
    -------
    str
        The mixed colour, as ``#rrggbb``.
    """
    return _hex(255 - strength * (255 - channel) for channel in channels(colour))


def channels(colour: str) -> tuple[int, int, int]:
    """Return red, green and blue of a colour, ``#rrggbb``, from 0 to 255.

    Examples
    --------
    >>> channels("#0072b2")
    (0, 114, 178)
    """
    red, green, blue = bytes.fromhex(colour[1:])
    return red, green, blue


def _hex(mixed: Iterable[float]) -> str:
    return "#" + "".join(f"{round(channel):02x}" for channel in mixed)
