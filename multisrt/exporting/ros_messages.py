"""Messages of ROS 2 as bytes; their fields are those of `ros_definitions`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from struct import Struct
from typing import Final

import numpy as np

from multisrt.events import Pose
from multisrt.exporting.cdr import CdrWriter
from multisrt.exporting.contents import Colour
from multisrt.exporting.grids import Cells, Grid
from multisrt.geometry.numerics.arrays import FloatArray

FIXED_FRAME: Final = "map"
"""The frame of the environment."""

LINE_LIST, SPHERES, POINTS, TEXT, TRIANGLES = 5, 7, 8, 9, 11
"""Types of markers."""

ADD, DELETE = 0, 2
"""Actions on markers."""

INFO, WARN = 20, 30
"""Levels of logged messages."""

_TIME, _POSE, _GRID = Struct("<iI"), Struct("<7d"), Struct("<fII")
_VECTOR, _COLOUR, _MARKER, _DURATION = Struct("<3d"), Struct("<4f"), Struct("<3i"), Struct("<iI")
_BYTE, _DOUBLE = Struct("<B"), Struct("<d")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Marker:
    """A shape in a scene.

    Attributes
    ----------
    namespace : str
        A marker replaces the one before it in the same namespace.
    kind : int
        Type: `LINE_LIST`, `SPHERES`, `POINTS`, `TEXT` or `TRIANGLES`.
    points : (n, 2) array
        Points in metres, in the frame.
    colour : (red, green, blue, opacity)
        From 0 to 1.
    width_m : float
        Width of lines, diameter of points, height of letters.
    height_m : float
        Height above the ground; higher markers cover lower ones.
    frame : str
        Frame of the points.
    locked : bool
        Whether it moves with the frame.
    text : str
        Text of a marker of kind `TEXT`, shown at its only point.
    """

    namespace: str
    kind: int
    points: FloatArray
    colour: Colour
    width_m: float
    height_m: float
    frame: str = FIXED_FRAME
    locked: bool = False
    text: str = ""


def occupancy_grid(now: int, grid: Grid, cells: Cells) -> bytes:
    """Return a `nav_msgs/OccupancyGrid`; `now` is in nanoseconds, here and below."""
    message = CdrWriter()
    _header(message, now, FIXED_FRAME)
    _time(message, now)
    message.numbers(_GRID, 4, grid.cell_m, grid.columns, grid.rows)
    _pose(message, (grid.x0, grid.y0, 0.0))
    message.count(cells.size)
    message.array(np.ascontiguousarray(cells))
    return message.bytes()


def pose_stamped(now: int, pose: Pose) -> bytes:
    """Return a `geometry_msgs/PoseStamped`."""
    message = CdrWriter()
    _header(message, now, FIXED_FRAME)
    _pose(message, pose)
    return message.bytes()


def transform(now: int, pose: Pose, child: str) -> bytes:
    """Return a `tf2_msgs/TFMessage` with the pose of a frame in the fixed frame."""
    message = CdrWriter()
    message.count(1)
    _header(message, now, FIXED_FRAME)
    message.text(child)
    _pose(message, pose)
    return message.bytes()


def path(now: int, stamps: Sequence[int], poses: Sequence[Pose]) -> bytes:
    """Return a `nav_msgs/Path` whose poses have stamps of their own."""
    message = CdrWriter()
    _header(message, now, FIXED_FRAME)
    message.count(len(poses))
    for stamp, pose in zip(stamps, poses, strict=True):
        _header(message, stamp, FIXED_FRAME)
        _pose(message, pose)
    return message.bytes()


def marker_array(now: int, markers: Sequence[Marker]) -> bytes:
    """Return a `visualization_msgs/MarkerArray`; a marker without points deletes the one before."""
    message = CdrWriter()
    message.count(len(markers))
    for marker in markers:
        _marker(message, now, marker)
    return message.bytes()


def _marker(message: CdrWriter, now: int, marker: Marker) -> None:
    count, is_text = len(marker.points), marker.kind == TEXT
    x, y = marker.points[0].tolist() if is_text else (0.0, 0.0)
    size_m = 1.0 if marker.kind == TRIANGLES else marker.width_m
    _header(message, now, marker.frame)
    message.text(marker.namespace)
    message.numbers(_MARKER, 4, 0, marker.kind, ADD if count else DELETE)
    message.numbers(_POSE, 8, x, y, marker.height_m if is_text else 0.0, 0.0, 0.0, 0.0, 1.0)
    message.numbers(_VECTOR, 8, size_m, size_m, size_m)
    message.numbers(_COLOUR, 4, *marker.colour)
    message.numbers(_DURATION, 4, 0, 0)  # lifetime: until it is replaced
    message.numbers(_BYTE, 1, marker.locked)
    message.count(0 if is_text else count)
    if not is_text:
        message.array(np.column_stack([marker.points, np.full(count, marker.height_m)]))
    message.count(0)  # colours of single points
    message.text("")  # texture_resource
    _header(message, 0, "")  # texture
    message.text("")
    message.count(0)
    message.count(0)  # uv_coordinates
    message.text(marker.text)
    message.text("")  # mesh_resource
    message.text("")  # mesh_file
    message.count(0)
    message.numbers(_BYTE, 1, False)  # mesh_use_embedded_materials


def log(now: int, level: int, name: str, text: str) -> bytes:
    """Return a `rcl_interfaces/Log`."""
    message = CdrWriter()
    _time(message, now)
    message.numbers(_BYTE, 1, level)
    message.text(name)
    message.text(text)
    message.text("")  # file
    message.text("")  # function
    message.count(0)  # line
    return message.bytes()


def float64(value: float) -> bytes:
    """Return a `std_msgs/Float64`."""
    message = CdrWriter()
    message.numbers(_DOUBLE, 8, value)
    return message.bytes()


def _header(message: CdrWriter, now: int, frame: str) -> None:
    _time(message, now)
    message.text(frame)


def _time(message: CdrWriter, now: int) -> None:
    message.numbers(_TIME, 4, *divmod(now, 1_000_000_000))


def _pose(message: CdrWriter, pose: Pose) -> None:
    x, y, heading = pose
    half = 0.5 * heading
    message.numbers(_POSE, 8, x, y, 0.0, 0.0, 0.0, math.sin(half), math.cos(half))
