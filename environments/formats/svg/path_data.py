"""Path data of SVG as polylines.

Source: W3C, Scalable Vector Graphics 2, chapter 9 (grammar) and appendix B.2 (arcs); differs in:
invalid data raise an error, where browsers draw the data before it.
"""

import math
import re
from typing import Final, NamedTuple

import numpy as np

from multisrt.environments.formats.curves import arc_points, cubic_points
from multisrt.environments.formats.regions import MAX_POINTS
from multisrt.environments.formats.svg.lengths import NUMBER, SvgError, number
from multisrt.geometry.errors import shown
from multisrt.geometry.numerics.arrays import FloatArray

ARGUMENTS: Final = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
"""Number of arguments of each command."""

_SPACE: Final = re.compile(r"[\s,]*")


class Subpath(NamedTuple):
    """A polyline: its points as ``(n, 2)``, and whether the last is joined to the first."""

    points: FloatArray
    closed: bool


Point = tuple[float, float]


def subpaths(data: str, tolerance: float) -> list[Subpath]:
    """Return path data as polylines.

    Parameters
    ----------
    data : str
        The attribute ``d``.
    tolerance : float
        Maximum distance between curves and polylines, in user units.

    Returns
    -------
    list of Subpath
        One for each ``M``, and for what follows a ``Z`` without one.

    Raises
    ------
    SvgError
        If the data are wrong, or have too many points.

    Examples
    --------
    >>> square, = subpaths("M0 0h2v2h-2z", 0.1)
    >>> square.points.tolist(), square.closed
    ([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], True)
    """
    pen = _Pen(tolerance)
    at = _skip(data, 0)
    command = ""
    while at < len(data):
        if data[at].isalpha():
            command = data[at]
            if command.upper() not in ARGUMENTS:
                raise SvgError(f"{command!r} is not a command of path data")
            at = _skip(data, at + 1)
        elif command in ("", "Z", "z"):
            raise SvgError(f"path data have no command before {shown(data[at : at + 20])}")
        if not pen.has_begun and command not in "Mm":
            raise SvgError(f"path data begin with {command!r} and not with M")
        values = []
        for index in range(ARGUMENTS[command.upper()]):
            is_flag = command in "Aa" and index in (3, 4)
            word = data[at] if is_flag and data[at : at + 1] in ("0", "1") else None
            if not is_flag and (found := NUMBER.match(data, at)):
                word = found.group()
            if word is None:
                raise SvgError(
                    f"path data have {shown(data[at : at + 20])} where {command} needs a "
                    + ("flag 0 or 1" if is_flag else "number")
                )
            values.append(number(word))
            at = _skip(data, at + len(word))
        pen.draw(command, values)
        if command in "Mm":  # further pairs of numbers are lines
            command = "L" if command == "M" else "l"
    return pen.finished()


def _skip(data: str, at: int) -> int:
    found = _SPACE.match(data, at)
    return found.end() if found else at


class _Pen:
    """The current point, and what has been drawn."""

    def __init__(self, tolerance: float) -> None:
        self._tolerance = tolerance
        self._done: list[Subpath] = []
        self._points: list[FloatArray] = []
        self._here: Point = (0.0, 0.0)
        self._start: Point = (0.0, 0.0)
        # The last control point, where the last command was a cubic or a quadratic curve.
        self._control: tuple[str, Point] = ("", (0.0, 0.0))
        self._count = 0
        self.has_begun = False

    def draw(self, command: str, values: list[float]) -> None:
        """Draw one command."""
        kind = command.upper()
        x, y = self._here if command.islower() else (0.0, 0.0)
        control: tuple[str, Point] = ("", (0.0, 0.0))
        match kind, values:
            case "M", [dx, dy]:
                self._end(closed=False)
                self._here = self._start = (x + dx, y + dy)
            case "Z", _:
                self._begin()
                self._end(closed=True)
                self._here = self._start
            case "L", [dx, dy]:
                self._line((x + dx, y + dy))
            case "H", [dx]:
                self._line((x + dx, self._here[1]))
            case "V", [dy]:
                self._line((self._here[0], y + dy))
            case "C", [x1, y1, x2, y2, dx, dy]:
                second = (x + x2, y + y2)
                self._cubic((x + x1, y + y1), second, (x + dx, y + dy))
                control = ("C", second)
            case "S", [x2, y2, dx, dy]:
                second = (x + x2, y + y2)
                self._cubic(self._reflected("C"), second, (x + dx, y + dy))
                control = ("C", second)
            case "Q", [x1, y1, dx, dy]:
                first = (x + x1, y + y1)
                self._quadratic(first, (x + dx, y + dy))
                control = ("Q", first)
            case "T", [dx, dy]:
                first = self._reflected("Q")
                self._quadratic(first, (x + dx, y + dy))
                control = ("Q", first)
            case "A", [rx, ry, turn, large, sweep, dx, dy]:
                self._arc((rx, ry), turn, bool(large), bool(sweep), (x + dx, y + dy))
        self._control = control
        self.has_begun = True

    def finished(self) -> list[Subpath]:
        """Return the subpaths drawn so far."""
        self._end(closed=False)
        return self._done

    def _begin(self) -> None:
        if not self._points:
            self._points.append(np.array([self._here]))

    def _end(self, *, closed: bool) -> None:
        if self._points:
            points = np.concatenate(self._points)
            if closed and len(points) > 1 and (points[0] == points[-1]).all():
                points = points[:-1]
            self._done.append(Subpath(points, closed))
            self._points = []

    def _add(self, points: FloatArray) -> None:
        self._count += len(points)
        if self._count > MAX_POINTS:
            raise SvgError(f"the path has more than {MAX_POINTS:,} points")
        if not np.abs(points).max() <= 1e15:
            raise SvgError("the path has a coordinate beyond 1e15")
        self._points.append(points)
        self._here = (float(points[-1, 0]), float(points[-1, 1]))

    def _line(self, end: Point) -> None:
        self._begin()
        self._add(np.array([end]))

    def _cubic(self, first: Point, second: Point, end: Point) -> None:
        self._begin()
        self._add(cubic_points(np.array([self._here, first, second, end]), self._tolerance))

    def _quadratic(self, control: Point, end: Point) -> None:
        x, y = control
        (x0, y0), (x1, y1) = self._here, end
        self._cubic(
            (x0 + 2 / 3 * (x - x0), y0 + 2 / 3 * (y - y0)),
            (x1 + 2 / 3 * (x - x1), y1 + 2 / 3 * (y - y1)),
            end,
        )

    def _reflected(self, kind: str) -> Point:
        """Return the last control point mirrored at the current one, after a curve of that kind."""
        (x, y), (last, (cx, cy)) = self._here, self._control
        return (2 * x - cx, 2 * y - cy) if last == kind else (x, y)

    def _arc(self, radii: Point, degrees: float, large: bool, sweep: bool, end: Point) -> None:
        rx, ry = abs(radii[0]), abs(radii[1])
        (x0, y0), (x1, y1) = self._here, end
        if rx == 0.0 or ry == 0.0 or (x0, y0) == (x1, y1):
            self._line(end)
            return
        turn = math.radians(degrees)
        cos, sin = math.cos(turn), math.sin(turn)
        # The middle of the chord in the frame of the axes, in radii.
        dx, dy = (x0 - x1) / 2, (y0 - y1) / 2
        u, v = (cos * dx + sin * dy) / rx, (cos * dy - sin * dx) / ry
        far = math.hypot(u, v)
        if not far <= 1e12:
            raise SvgError("an arc has radii that are too small for its ends")
        if far > 1.0:  # radii too small for the chord are scaled up to reach it
            rx, ry, u, v, far = rx * far, ry * far, u / far, v / far, 1.0
        if far == 0.0:
            self._line(end)
            return
        shift = math.sqrt(max(0.0, 1.0 - far * far)) / far
        if large == sweep:
            shift = -shift
        cu, cv = shift * v, -shift * u
        start, stop = math.atan2(v - cv, u - cu), math.atan2(-v - cv, -u - cu)
        angle = (stop - start) % (2 * math.pi)
        if not sweep:
            angle -= 2 * math.pi
        a, b = rx * cu, ry * cv
        center = (cos * a - sin * b + (x0 + x1) / 2, sin * a + cos * b + (y0 + y1) / 2)
        points = arc_points(center, (rx, ry), (start, angle), self._tolerance, turn=turn)
        points[-1] = end
        self._begin()
        self._add(points)
