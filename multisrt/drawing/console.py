"""A map of a team as text for the terminal: walls, what was seen, and the robots.

With colours a character is two squares, one above the other; without, it is one tall cell.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from functools import cache
from typing import Final, Literal

import numpy as np
import numpy.typing as npt
import shapely

from multisrt.drawing.colours import ROBOT_COLOURS, WHITE, tint
from multisrt.environments.environment import Environment
from multisrt.events import Point
from multisrt.geometry.numerics.arrays import FloatArray

Ink = Literal["ascii", "plain", "256", "true"]
"""What a terminal can show: letters; shades of blocks; blocks in 256 colours; in any colour."""

SAMPLES: Final = 8
"""Samples along each side of a pixel, by which it is free or not."""

MAX_BLOCKED: Final = 0.12
"""Share of a free pixel that obstacles may cover, so small that thin walls are drawn."""

WALL, UNSEEN = -2, -1
"""What a pixel shows, if not the number of the robot that saw it first."""

WALL_COLOUR: Final = "#0c0d0f"
UNSEEN_COLOUR: Final = "#4b5058"
SEEN_SHARE: Final = 0.4
SEEN_SHARE_256: Final = 0.6
"""Strength of a robot's colour in the area that it saw first. With 256 colours, the nearest ones to
weaker tints of different robots would be the same."""

SIGNS: Final[Mapping[Ink, str]] = {"ascii": "# .", "plain": "█ ░"}
"""Characters for walls, unseen and seen area where there are no colours."""

RESET: Final = "\x1b[0m"


class ConsoleMap:
    """The map of a world in the cells of a terminal.

    Parameters
    ----------
    environment : Environment
        The world.
    columns, rows : int
        Cells that the map may fill; it keeps its proportions.
    ink : {"ascii", "plain", "256", "true"}
        What the terminal can show.

    Examples
    --------
    >>> import multisrt as ms
    >>> from multisrt.environments.catalog import environment
    >>> console = ConsoleMap(environment("apartment"), 24, 12, "ascii")
    >>> len(console.lines({0: (1.0, 1.0)})) <= 12
    True
    """

    def __init__(self, environment: Environment, columns: int, rows: int, ink: Ink) -> None:
        x0, y0, x1, y1 = environment.bounds
        self._ink = ink
        self._tall = 1 if self._coloured else 2
        # A cell is twice as high as wide. Outside of the bounds is one cell of wall on each side.
        columns, rows = max(1, columns - 2), max(1, rows - 2)
        self._m = max((x1 - x0) / columns, (y1 - y0) / (2 * rows))
        self._corner = (x0 - self._m, y1 + 2 * self._m)
        wide = math.ceil((x1 - x0) / self._m - 1e-9) + 2
        high = math.ceil((y1 - y0) / (2 * self._m) - 1e-9) + 2
        self._shape = (high * 2 // self._tall, wide)
        self._points, free = self._sampled(environment)
        self._shown = np.where(free, UNSEEN, WALL)

    @property
    def _coloured(self) -> bool:
        return self._ink in ("256", "true")

    @property
    def width(self) -> int:
        """Number of columns that the map fills."""
        return self._shape[1]

    def add_seen(self, robot: int, region: FloatArray) -> None:
        """Take in what a robot saw.

        Parameters
        ----------
        robot : int
            Its number.
        region : (n, 2) array
            Corners of the region in metres. What was seen before stays as it is.
        """
        if len(region) < 3:
            return
        rows, columns = self._box(region)
        shown, points = self._shown[rows, columns], self._points[rows, columns]
        new = shown == UNSEEN
        if new.any():
            polygon = shapely.Polygon(region)
            shapely.prepare(polygon)
            new[new] = shapely.intersects_xy(polygon, *points[new].T)
            shown[new] = robot

    def lines(self, places: Mapping[int, Point], dead: Collection[int] = ()) -> list[str]:
        """Return the lines of the map.

        Parameters
        ----------
        places : mapping of int to (x, y)
            Where robots are, by number; a later one is above the others.
        dead : collection of int
            Robots that died, which are crossed out.

        Returns
        -------
        list of str
            One for each row, equally wide. With colours each line begins with its own and ends
            without any.
        """
        labels = self._labels(places, dead)
        if self._coloured:
            pairs = self._shown.reshape(-1, 2, self._shape[1])
            return [
                self._coloured_line(upper, lower, labels.get(k, {}))
                for k, (upper, lower) in enumerate(pairs)
            ]
        return [self._plain_line(row, labels.get(k, {})) for k, row in enumerate(self._shown)]

    def key(self, columns: int, *, team: bool, dead: bool) -> str:
        """Return a line that explains the signs of the map.

        Parameters
        ----------
        columns : int
            Upper bound of its width; entries that do not fit are left out.
        team : bool
            Whether there are several robots.
        dead : bool
            Whether a robot has died.

        Returns
        -------
        str
            Samples and their meanings. With colours it ends without any.
        """
        seen = "seen first by a robot" if team and self._coloured else "seen"
        entries = list(zip(self._samples(team), ("wall", "not seen", seen), strict=True))
        entries.append(("0 1", "robots") if team else ("0", "robot"))
        if dead:
            entries.append(("x", "dead robot"))
        shown: list[str] = []
        used = 0
        for sample, meaning in entries:
            width = len(re.sub(r"\x1b\[[0-9;]*m", "", sample))
            used += (2 if shown else 0) + width + 1 + len(meaning)
            if used > columns:
                break
            shown.append(f"{sample} {meaning}")
        return "  ".join(shown)

    def _samples(self, team: bool) -> tuple[str, str, str]:
        # Of wall, unseen area, and area that was seen.
        if not self._coloured:
            # A blank alone would not show that it is a sample.
            wall, unseen, seen = (repr(sign) if sign == " " else sign for sign in SIGNS[self._ink])
            return wall, unseen, seen
        wall, unseen, first, second = (
            f"\x1b[0;{_code(_colour(value, self._ink), self._ink, 48)}m {RESET}"
            for value in (WALL, UNSEEN, 0, 1)
        )
        return wall, unseen, first + second if team else first

    def _labels(
        self, places: Mapping[int, Point], dead: Collection[int]
    ) -> dict[int, dict[int, tuple[str, int]]]:
        # By row and column the letters of robots' numbers, and whose they are.
        found: dict[int, dict[int, tuple[str, int]]] = {}
        high, wide = len(self._shown) * self._tall // 2, self._shape[1]
        for robot, (x, y) in places.items():
            text = "x" if robot in dead else str(robot)
            row = int((self._corner[1] - y) / (2 * self._m))
            column = int((x - self._corner[0]) / self._m - (len(text) - 1) / 2)
            row = min(max(row, 0), high - 1)
            column = min(max(column, 0), max(0, wide - len(text)))
            for k, letter in enumerate(text[:wide]):
                found.setdefault(row, {})[column + k] = (letter, robot)
        return found

    def _plain_line(self, row: npt.NDArray[np.int64], labels: dict[int, tuple[str, int]]) -> str:
        wall, unseen, seen = tuple(SIGNS[self._ink])
        signs = {WALL: wall, UNSEEN: unseen}
        return "".join(
            labels[k][0] if k in labels else signs.get(value, seen)
            for k, value in enumerate(row.tolist())
        )

    def _coloured_line(
        self,
        upper: npt.NDArray[np.int64],
        lower: npt.NDArray[np.int64],
        labels: dict[int, tuple[str, int]],
    ) -> str:
        parts, last = [], ""
        for k, (top, bottom) in enumerate(zip(upper.tolist(), lower.tolist(), strict=True)):
            if k in labels:
                sign, robot = labels[k]
                paint = f"\x1b[1;{_code(WHITE, self._ink)};{_code(_own(robot), self._ink, 48)}m"
            else:
                sign = "▀" if top != bottom else " "
                above = f"{_code(_colour(top, self._ink), self._ink)};" if top != bottom else ""
                paint = f"\x1b[0;{above}{_code(_colour(bottom, self._ink), self._ink, 48)}m"
            parts.append(sign if paint == last else paint + sign)
            last = paint
        return "".join(parts) + RESET

    def _box(self, region: FloatArray) -> tuple[slice, slice]:
        # Rows and columns of the pixels that a region may touch.
        (x0, y0), (x1, y1) = region.min(axis=0), region.max(axis=0)
        left, top = self._corner
        high = self._m * self._tall
        return (
            slice(max(0, int((top - y1) / high)), max(0, int((top - y0) / high) + 1)),
            slice(max(0, int((x0 - left) / self._m)), max(0, int((x1 - left) / self._m) + 1)),
        )

    def _sampled(self, environment: Environment) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Return for each pixel a point of its free space near the centre, and whether it is free.

        Of a pixel that is not, the point has no meaning.
        """
        rows, columns = self._shape
        offsets = (np.arange(SAMPLES) + 0.5) / SAMPLES
        x = self._corner[0] + self._m * (np.arange(columns)[:, None] + offsets).ravel()
        y = self._corner[1] - self._m * self._tall * (np.arange(rows)[:, None] + offsets).ravel()
        at = np.stack(np.meshgrid(x, y), axis=-1)
        free = environment.free
        shapely.prepare(free)
        # By pixel, then by sample.
        at = at.reshape(rows, SAMPLES, columns, SAMPLES, 2).swapaxes(1, 2)
        at = at.reshape(rows, columns, SAMPLES * SAMPLES, 2)
        inside = shapely.intersects_xy(free, at[..., 0], at[..., 1])
        off = np.abs(offsets - 0.5)
        away = (off[:, None] + off[None, :]).ravel()
        nearest = np.where(inside, away, np.inf).argmin(axis=2)
        points = np.take_along_axis(at, nearest[:, :, None, None], axis=2)[:, :, 0]
        return points, inside.mean(axis=2) >= 1.0 - MAX_BLOCKED


def _own(robot: int) -> str:
    return ROBOT_COLOURS[robot % len(ROBOT_COLOURS)]


@cache
def _colour(value: int, ink: Ink) -> str:
    if value < 0:
        return WALL_COLOUR if value == WALL else UNSEEN_COLOUR
    return tint(_own(value), SEEN_SHARE_256 if ink == "256" else SEEN_SHARE)


@cache
def _code(colour: str, ink: Ink, ground: int = 38) -> str:
    """Return the parameters that select a colour, of letters (38) or behind them (48)."""
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    if ink == "true":
        return f"{ground};2;{red};{green};{blue}"
    levels = (0, 95, 135, 175, 215, 255)
    r, g, b = (
        min((abs(level - own), k) for k, level in enumerate(levels))[1]
        for own in (red, green, blue)
    )
    if r == g == b:
        # Greys have finer steps of their own.
        step = min(23, max(0, round((red - 8) / 10)))
        return f"{ground};5;{232 + step if red < 243 else 231}"
    return f"{ground};5;{16 + 36 * r + 6 * g + b}"
