"""What things look like: readable in grey, and by people who do not see red from green.

Nothing is told by its colour alone: kinds of lines also differ by width and dashes, kinds of
nodes by their shape. Source of most colours: Okabe and Ito, Color Universal Design, 2008.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

from multisrt.drawing.svg import plain

WHITE: Final = "#ffffff"
INK: Final = "#1a1a1a"
VERMILION: Final = "#b94600"
"""Darker than in the source, so that it stands out in grey, too."""


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
"""Colours of robots, in turn. Vermilion is the frontier's, black and grey are the world's."""

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
"""Dashes of robots' trees, in turn, one further each time that all colours are used up."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Style:
    """How a shape is filled and stroked; lengths are millimetres on paper.

    Attributes
    ----------
    fill, stroke : str or None
        Colours; None: not filled, not stroked.
    fill_opacity, stroke_opacity : float
        From 0 to 1.
    width_mm : float
        Width of the stroke.
    dashes_mm : tuple of float
        Lengths of dashes and gaps; empty: a solid line.
    """

    fill: str | None = None
    stroke: str | None = None
    fill_opacity: float = 1.0
    stroke_opacity: float = 1.0
    width_mm: float = 0.2
    dashes_mm: tuple[float, ...] = ()

    def attributes(self, mm: float) -> dict[str, str]:
        """Give the SVG attributes where a millimetre on paper is `mm` user units."""
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
        """Give the style with a finer or a wider stroke."""
        dashes = tuple(factor * length for length in self.dashes_mm)
        return replace(self, width_mm=factor * self.width_mm, dashes_mm=dashes)


OBSTACLE: Final = Style(fill="#a3a3a3", stroke=INK, width_mm=0.18)
FREE: Final = Style(fill=WHITE)
FREE_SAMPLE: Final = Style(fill=WHITE, stroke=INK, width_mm=0.18)
FRONTIER: Final = Style(stroke=VERMILION, width_mm=0.9)
START: Final = Style(fill=WHITE, stroke=INK, width_mm=0.35)
END: Final = Style(fill=INK, stroke=WHITE, width_mm=0.25)
SUGGESTED_START: Final = Style(fill=WHITE, stroke=INK, width_mm=0.35)
COLLISION: Final = Style(stroke=VERMILION, width_mm=0.8)

CLOSED: Final = {
    "too narrow": Style(stroke=INK, width_mm=0.7, dashes_mm=(0.4, 0.35)),
    "not reachable": Style(stroke=INK, width_mm=0.7, dashes_mm=(1.4, 0.5)),
    "seen from near": Style(stroke=INK, width_mm=0.7, dashes_mm=(1.4, 0.4, 0.4, 0.4)),
}
"""Arcs that were given up, by reason."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotStyles:
    """How what belongs to one robot is drawn."""

    region: Style
    path: Style
    edge: Style
    node: Style

    @classmethod
    def of(cls, robot: int) -> RobotStyles:
        """Give a robot's styles; 64 robots differ, then they repeat."""
        turn, number = divmod(robot, len(ROBOT_COLOURS))
        colour = ROBOT_COLOURS[number]
        dashes = ROBOT_DASHES_MM[(number + turn) % len(ROBOT_DASHES_MM)]
        return cls(
            # Where many regions overlap the sum is the fill itself, which is therefore light.
            region=Style(
                fill=tint(colour, 0.36),
                fill_opacity=0.65,
                stroke=colour,
                stroke_opacity=0.45,
                width_mm=0.09,
            ),
            path=Style(stroke=INK, width_mm=0.14, dashes_mm=(0.5, 0.4)),
            edge=Style(stroke=colour, width_mm=0.4, dashes_mm=dashes),
            node=Style(fill=colour, stroke=WHITE, width_mm=0.12),
        )


def tint(colour: str, strength: float) -> str:
    """Mix a colour with white.

    Parameters
    ----------
    colour : str
        As ``#rrggbb``.
    strength : float
        Share of the colour, from 0 (white) to 1.
    """
    channels = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(f"{round(255 - strength * (255 - c)):02x}" for c in channels)
