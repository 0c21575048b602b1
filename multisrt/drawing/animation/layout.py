"""Where the parts of a picture are: the title, the map, and the lines below it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from multisrt.drawing.svg import Bounds
from multisrt.geometry.errors import InvalidInputError

WIDTH: Final = 960
"""Default width of a picture, in pixels."""

SIZES: Final = (200, 4096)
"""Range of width and height, in pixels."""

PX_PER_MM: Final = 2.9
"""Pixels for a millimetre of the styles in a picture of the default width."""

MAX_ASPECT: Final = 1.4
"""Largest height of the map for its width, where the height of a picture is not given."""

MARGIN: Final = 14.0
"""Margin in a picture of the default width, in pixels."""

TITLE: Final = 17.0
TEXT: Final = 14.0
LABEL: Final = 12.0
"""Sizes of letters in a picture of the default width, in pixels: of the title, of other lines, and
of numbers on the map."""

MIN_LETTERS: Final = 12.5
"""Lower bound of the size of letters, in pixels of the picture: digits are 9 pixels high."""

ROW: Final = 22.0 / TEXT
ENTRY: Final = 152.0 / TEXT
SWATCH: Final = 12.0 / TEXT
"""Height of a row below the map, width of the entry of a robot, and of its swatch, in sizes of
letters."""

FRAME: Final = 5.0
"""Width of the surroundings drawn around free space."""

MIN_MAP: Final = 60.0
"""Least width and height of the map, in pixels of the picture."""

MAX_ENTRIES: Final = 16
"""Largest team whose robots are listed below the map."""


def letters_px(size: float, unit: float) -> float:
    """Return the size of letters in pixels, for their size in a picture of the default width."""
    return max(MIN_LETTERS, size * unit)


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """The parts of a picture, in pixels from its upper left corner.

    Attributes
    ----------
    width, height : int
        Size of the picture.
    unit : float
        Factor of lengths that are given for the default width.
    scale : float
        Pixels for a metre.
    map : (x, y, width, height)
        The map with its surroundings.
    origin : (x, y)
        Where the point (0, 0) of the world would be.
    captioned : bool
        Whether there are a title, the time, and the list of robots.
    columns : int
        Robots in a row of the list.
    """

    width: int
    height: int
    unit: float
    scale: float
    map: tuple[float, float, float, float]
    origin: tuple[float, float]
    captioned: bool
    columns: int

    @property
    def mm(self) -> float:
        """Metres of the world for a millimetre of the styles."""
        return PX_PER_MM * self.unit / self.scale

    @property
    def title_px(self) -> float:
        """Size of the letters of the title, in pixels."""
        return letters_px(TITLE, self.unit)

    @property
    def text_px(self) -> float:
        """Size of the letters of other lines, in pixels."""
        return letters_px(TEXT, self.unit)

    @property
    def label_px(self) -> float:
        """Size of the numbers on the map, in pixels."""
        return letters_px(LABEL, self.unit)

    @property
    def row_px(self) -> float:
        """Height of a row below the map, in pixels."""
        return ROW * self.text_px

    @property
    def swatch_px(self) -> float:
        """Width of the swatch of a robot, in pixels."""
        return SWATCH * self.text_px

    @property
    def title_y(self) -> float:
        """Middle of the line of the title, in pixels."""
        return MARGIN * self.unit + 0.5 * self.title_px

    @property
    def caption_y(self) -> float:
        """Where the lines below the map begin."""
        return self.map[1] + self.map[3] + 0.5 * MARGIN * self.unit

    def entry(self, robot: int) -> tuple[float, float]:
        """Return the left end and the middle of the entry of a robot."""
        row, column = divmod(robot, self.columns)
        y = self.caption_y + (1.5 + row) * self.row_px
        return MARGIN * self.unit + column * ENTRY * self.text_px, y


def layout_of(
    bounds: Bounds,
    robots: int,
    width: int = WIDTH,
    height: int | None = None,
    *,
    captioned: bool = True,
) -> Layout:
    """Return the layout of the pictures of a run.

    Parameters
    ----------
    bounds : (x0, y0, x1, y1)
        Extent of the world in metres.
    robots : int
        Number of robots.
    width : int
        Width in pixels.
    height : int, optional
        Height; by default what the map needs.
    captioned : bool
        Whether there are a title and lines below the map.

    Returns
    -------
    Layout
        The layout, the same for all pictures of the run.

    Raises
    ------
    InvalidInputError
        If the size is out of range, or too small for the map and the lines below.
    """
    for what, size in (("width", width), ("height", height)):
        if size is not None and not SIZES[0] <= size <= SIZES[1]:
            raise InvalidInputError(
                f"the {what} of the animation is {size} pixels; give {SIZES[0]} to {SIZES[1]}"
            )
    x0, y0, x1, y1 = bounds
    unit = width / WIDTH
    margin, frame = MARGIN * unit, FRAME * unit
    title_px, text_px = letters_px(TITLE, unit), letters_px(TEXT, unit)
    columns = max(1, math.floor((width - 2.0 * margin) / (ENTRY * text_px)))
    rows = 1 + (math.ceil(robots / columns) if robots <= MAX_ENTRIES else 0)
    above = margin + (1.4 * title_px if captioned else 0.0)
    below = margin + (rows * ROW * text_px + 0.5 * margin if captioned else 0.0)
    wide = width - 2.0 * margin
    if height is None:
        natural = (wide - 2.0 * frame) * (y1 - y0) / (x1 - x0) + 2.0 * frame
        high = min(natural, MAX_ASPECT * wide)
        height = math.ceil(above + high + below)
        if height > SIZES[1]:
            raise InvalidInputError(
                f"the picture would be {height} pixels high, of at most {SIZES[1]}; "
                "give a smaller width"
            )
    high = height - above - below
    if min(high, wide) < MIN_MAP:
        raise InvalidInputError(
            f"{width} x {height} pixels leave no room for the map below the title and above the "
            f"list of robots; give a height of at least {math.ceil(above + below + MIN_MAP)}"
        )
    scale = min((wide - 2.0 * frame) / (x1 - x0), (high - 2.0 * frame) / (y1 - y0))
    map_wide, map_high = scale * (x1 - x0) + 2.0 * frame, scale * (y1 - y0) + 2.0 * frame
    left, top = (width - map_wide) / 2.0, above + (high - map_high) / 2.0
    return Layout(
        width=width,
        height=height,
        unit=unit,
        scale=scale,
        map=(left, top, map_wide, map_high),
        origin=(left + frame - scale * x0, top + frame + scale * y1),
        captioned=captioned,
        columns=columns,
    )
