"""Options for exporting a run: layers and sampling rates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from multisrt.drawing.layers import left_out
from multisrt.geometry.errors import InvalidInputError

MAX_RATE_HZ: Final = 1000.0
"""Upper bound of the rate of poses, in hertz."""

MIN_INTERVAL_S: Final = 0.01
"""Lower bound of the time between two maps, in seconds."""

MAX_S: Final = 1e9
"""Upper bound of intervals, in seconds."""

MIN_CELL_M, MAX_CELL_M = 1e-3, 1e3
"""Bounds of the width of a cell, in metres."""


def require_cell_width(cell_m: float | None) -> None:
    """Check the width of the cells of maps, in metres; None is the default of a format.

    Raises
    ------
    InvalidInputError
        If it is out of range.
    """
    # Written so that NaN is refused, too.
    if cell_m is not None and not MIN_CELL_M <= cell_m <= MAX_CELL_M:
        raise InvalidInputError(
            f"cells of maps must be {MIN_CELL_M:g} to {MAX_CELL_M:g} m wide, not {cell_m:g}"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportOptions:
    """Options for exporting a run to other programs: layers and sampling rates.

    Attributes
    ----------
    rate_hz : float
        Poses of a moving robot per second, in addition to its waypoints. A standing robot has one
        each second, or at this rate if it is lower.
    map_interval_s : float
        Time between two maps of a robot, in seconds. Unchanged maps are left out.
    cell_m : float or None
        Width of a cell of the maps, in metres. By default 0.1 m, doubled until a map has at most a
        million cells.
    without : tuple of str
        Layers to leave out: names of `multisrt.drawing.layers.PICTURES` of an export.

    Raises
    ------
    InvalidInputError
        If a number is out of range, or an export has no such layer.

    Examples
    --------
    >>> ExportOptions(rate_hz=2.0).map_interval_s
    5.0
    """

    rate_hz: float = 10.0
    map_interval_s: float = 5.0
    cell_m: float | None = None
    without: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        # Written so that NaN is refused, too.
        if not 0.0 < self.rate_hz <= MAX_RATE_HZ:
            raise InvalidInputError(
                f"the rate of poses must be above 0 and at most {MAX_RATE_HZ:g} Hz, "
                f"not {self.rate_hz:g}"
            )
        if not MIN_INTERVAL_S <= self.map_interval_s <= MAX_S:
            raise InvalidInputError(
                f"the interval of maps must be from {MIN_INTERVAL_S:g} to {MAX_S:g} s, "
                f"not {self.map_interval_s:g}"
            )
        require_cell_width(self.cell_m)
        left_out(self.without, "export")
