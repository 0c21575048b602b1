"""Worlds of the simulator Player/Stage: floorplans and other models, placed in metres."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.environments.cleaning import Cleaning, areas, flushed, without_denormals
from multisrt.environments.environment import MAX_COORDINATE_M, MIN_LENGTH_M, Environment
from multisrt.environments.formats.bitmap import MAX_CORNERS
from multisrt.environments.formats.files import (
    MAX_CELLS,
    FileStarts,
    build_environment,
    grid_polygons,
    named_file,
    no_such_file,
    refuse_resolution,
    refuse_threshold,
    require_length,
    straightened,
)
from multisrt.environments.formats.image import read_pixels
from multisrt.environments.formats.map_format import Beginning, MapFormat
from multisrt.environments.formats.regions import require_few_overlaps
from multisrt.environments.formats.worldfile import Entity, parse_worldfile
from multisrt.geometry.errors import MapFormatError, shortened
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.overlay import difference_of

FREE_SHARE: Final = 0.5
"""A pixel of a bitmap is free if its first channel is above this share of the largest value."""

SNAP_M: Final = 1e-6
"""Grid of the coordinates of several floorplans, so that rectangles that touch are joined."""

BOUNDARY_M: Final = 0.01
"""Thickness of the wall around a model with ``boundary 1``, in metres."""

DEFAULT_SIZE_M: Final = (0.1, 0.1)
"""Size of a model that has none, in metres."""

MAX_SIZE_M: Final = 1e5
"""Upper bound of the size of a model, in metres; the lower bound is `MIN_LENGTH_M`."""

MAX_BITMAPS: Final = 100
"""Upper bound of the different bitmaps of a world."""

OTHER_TYPES: Final = frozenset(
    (
        *("window", "gui", "block", "sensor", "camera", "ranger", "laser", "sonar", "ptz", "wifi"),
        *("actuator", "blinkenlight", "blobfinder", "bumper", "fiducial", "fiducialfinder"),
        *("gripper", "lightindicator", "loadcell", "indicator", "audio", "energy", "power"),
    )
)
"""Types that are neither obstacles nor robots: settings, parts of models and sensors."""

OF_ROBOTS: Final = frozenset(
    (
        *("ctrl", "drive", "velocity", "localization", "localization_origin", "odom_error"),
        *("wheelbase", "velocity_bounds", "acceleration_bounds"),
    )
)
"""Properties that only robots have: a controller, and those of the type ``position``."""

MAX_NAMES: Final = 5
"""Upper bound of the names of files that are listed in a message or in the origin of a world."""

MAX_TYPES_TOLD: Final = 5
"""Upper bound of the types that are not known and told in the origin of a world."""

UNITS_OF_LENGTH: Final = {"m": 1.0, "cm": 0.01, "mm": 0.001}
UNITS_OF_ANGLE: Final = {"degrees": math.pi / 180, "radians": 1.0}


def read_stage(
    path: Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
) -> Environment:
    """Read a world of Player/Stage; the frame is that of the world file.

    - Models with a ``bitmap`` are floorplans. As in Stage, a pixel is an obstacle if its first
      channel (grey or red) is at most 127 of 255, and the rectangle around all dark pixels is
      stretched to ``size``, so that pixels need not be square. ``pose`` is the centre and heading
      of the model, ``origin`` the pose of the rectangle relative to it. ``boundary`` adds walls of
      1 cm along its inside.
    - Models without a bitmap are obstacles: their ``block`` polygons or else a box, stretched to
      ``size``. Models that neither robots nor range finders detect (``obstacle_return 0`` with a
      negative ``ranger_return``, or ``laser_return 0``) are left out.
    - Free space is the union of the rectangles of all floorplans, without all obstacles. In a
      bitmap of outlines the inside of a block is free space too, as a separate component that no
      robot outside it reaches.
    - Models of the type ``position`` are robots. So are models without a bitmap but with a pose
      whose type is not known, because robots are usually defined in files that come with Stage
      and are stored elsewhere, if a model of that type has a controller (``ctrl``), a sensor or
      another model on it, or a property of positions such as ``localization``. If this leaves no
      robot at all, every type that is not known is one of robots. Their positions are the suggested
      starts, in the order of the file, if they are in free space; their headings are not used.

    A missing include is no error if there is a floorplan without it, since worlds are often passed
    on without the definitions of their robots. `Environment.origin` names it.

    Parameters
    ----------
    path : Path
        The world file. Bitmaps and included files must be in its folder or below.
    resolution_m, threshold
        Rejected: the file states the size of its bitmaps, and Stage's threshold applies.
    name : str, optional
        By default the file's name without suffix.

    Raises
    ------
    MapFormatError
        If the syntax is wrong, a value has another form or is out of range, there is no
        floorplan, or a bitmap is missing, damaged or outside the folder.

    Notes
    -----
    Source: Stage 4 (classes Model, BlockGroup and Worldfile, function polys_from_image_file).
    Differs in: heights are ignored, so that every model is an obstacle, whatever its height;
    space outside all floorplans is not free; ``pose`` and ``size`` may also lack z, as in Stage
    2 (x, y, heading and x, y); an unknown unit is an error.

    Examples
    --------
    >>> from PIL import Image
    >>> walls = Image.new("L", (40, 30), color=0)
    >>> walls.paste(255, (4, 3, 36, 27))
    >>> walls.save("walls.png")
    >>> with open("hall.world", "w") as file:
    ...     _ = file.write(
    ...         'model ( bitmap "walls.png" size [10 10 1] pose [5 5 0 90] )'
    ...         "position ( pose [3 4 0 0] )"
    ...     )
    >>> hall = read_stage(Path("hall.world"))
    >>> hall.bounds, hall.starts
    ((1.0, 1.0, 9.0, 9.0), ((3.0, 4.0),))
    """
    refuse_resolution(path, resolution_m)
    refuse_threshold(path, threshold)
    parsed = parse_worldfile(path)
    world = _World(path, _Units.of(parsed.root))
    world.add_children(parsed.root, _Pose())
    if not world.floorplans:
        raise MapFormatError(
            f"{path} has no model with a bitmap, so there is no floorplan"
            + (f"; is it in {_listed(parsed.missing)}, which is missing?" if parsed.missing else "")
        )
    free = world.free()
    shapely.prepare(free)
    robots, others = world.robots()
    inside = [place for place in robots if shapely.contains_xy(free, *place)]
    told = [f"{path.name} with {_listed(tuple(world.bitmaps))}"]
    told += [f"{shortened(missing)} is missing" for missing in parsed.missing]
    told += [f"{shortened(kind)} is not defined, and is no robot" for kind in others]
    if len(inside) < len(robots):
        told.append(f"{len(inside)} of {len(robots)} robots are in free space")
    return build_environment(
        path,
        free,
        name=name,
        origin="; ".join(told),
        starts=FileStarts(inside),
        cleaning=Cleaning(straightened_m=world.straightened_m),
        outlined_obstacles=True,
    )


def _listed(names: tuple[str, ...]) -> str:
    """Return the first of some names from a file, as text."""
    more = len(names) - MAX_NAMES
    some = ", ".join(shortened(name) for name in names[:MAX_NAMES])
    return f"{some} and {more} more" if more > 0 else some


# Values of properties -----------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Pose:
    """A position in metres and a heading in radians."""

    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0

    def __matmul__(self, inner: "_Pose") -> "_Pose":
        x, y = libm.product(np.array([[inner.x, inner.y]]), self.matrix.T)[0].tolist()
        return _Pose(self.x + x, self.y + y, self.heading + inner.heading)

    @property
    def matrix(self) -> FloatArray:
        """The rotation; exact where the heading is a multiple of a right angle."""
        cos, sin = round(math.cos(self.heading), 15), round(math.sin(self.heading), 15)
        return np.array([[cos, -sin], [sin, cos]])

    def place(self, shape: BaseGeometry) -> BaseGeometry:
        """Return a valid shape in the frame of this pose in the frame around it."""
        turn = self.matrix.T

        def placed(points: FloatArray) -> FloatArray:
            return flushed(libm.product(points, turn) + np.array([self.x, self.y]))

        moved = shapely.transform(shape, placed)
        if moved.is_valid:
            return moved
        # Far from the origin, rounding makes the finest details cross.
        return areas(shapely.make_valid(moved, method="structure", keep_collapsed=False))


@dataclass(frozen=True, slots=True)
class _Units:
    """The units of lengths and angles, and the properties of entities in metres and radians."""

    length: float
    angle: float

    @classmethod
    def of(cls, root: Entity) -> "_Units":
        length = _choice(root, "unit_length", UNITS_OF_LENGTH, "m")
        return cls(length, _choice(root, "unit_angle", UNITS_OF_ANGLE, "degrees"))

    def pose(self, entity: Entity, key: str) -> _Pose:
        values = _numbers(entity, key, (4, 3), "[x y z heading]")
        if values is None:
            return _Pose()
        x, y = (self.length * value for value in values[:2])
        if max(abs(x), abs(y)) > MAX_COORDINATE_M:
            raise MapFormatError(
                f"{entity.properties[key].place}: {key} is beyond {MAX_COORDINATE_M:g} m"
            )
        return _Pose(x, y, math.remainder(self.angle * values[-1], math.tau))

    def size(self, entity: Entity) -> tuple[float, float]:
        values = _numbers(entity, "size", (3, 2), "[x y z]")
        if values is None:
            return DEFAULT_SIZE_M
        width, height = (self.length * value for value in values[:2])
        if not all(MIN_LENGTH_M <= side <= MAX_SIZE_M for side in (width, height)):
            raise MapFormatError(
                f"{entity.properties['size'].place}: the size is {width:g} x {height:g} m; both "
                f"are at least {MIN_LENGTH_M:g} and at most {MAX_SIZE_M:g} m"
            )
        return width, height


def _choice(entity: Entity, key: str, choices: dict[str, float], default: str) -> float:
    found = entity.properties.get(key)
    word = default if found is None else found.values[0] if len(found.values) == 1 else ""
    if word not in choices:
        place = "" if found is None else found.place
        raise MapFormatError(f"{place}: {key} must be one of {', '.join(choices)}, in quotes")
    return choices[str(word)]


def _numbers(
    entity: Entity, key: str, lengths: tuple[int, ...], form: str
) -> tuple[float, ...] | None:
    found = entity.properties.get(key)
    if found is None:
        return None
    numbers = tuple(value for value in found.values if isinstance(value, float))
    if len(numbers) != len(found.values) or len(numbers) not in lengths:
        raise MapFormatError(f"{found.place}: {key} must be a tuple of numbers {form}")
    return numbers


def _number(entity: Entity, key: str, default: float) -> float:
    values = _numbers(entity, key, (1,), "with one number")
    return default if values is None else values[0]


# The world ----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Bitmap:
    """The free space of an image in a unit square around the origin, and its rows and columns."""

    free: BaseGeometry
    rows: int
    columns: int


@dataclass(frozen=True, slots=True)
class _Floorplan:
    """A model with a bitmap: its free space in its own frame, its rectangle and its pose."""

    free: BaseGeometry
    ground: Polygon
    pose: _Pose


@dataclass(slots=True)
class _World:
    """Content of a world read so far: floorplans, other obstacles, and what may be robots."""

    path: Path
    units: _Units
    floorplans: list[_Floorplan] = field(default_factory=list)
    obstacles: list[BaseGeometry] = field(default_factory=list)
    movable: list[tuple[str, tuple[float, float]]] = field(default_factory=list)
    robot_types: set[str] = field(default_factory=set)
    bitmaps: dict[str, _Bitmap] = field(default_factory=dict)
    pixels: int = 0
    straightened_m: float = 0.0
    corners: int = 0

    def add_children(self, parent: Entity, frame: _Pose) -> None:
        """Add the models in an entity, whose pose in the world is `frame`."""
        for entity in parent.children:
            if entity.kind in OTHER_TYPES:
                continue
            pose = frame @ self.units.pose(entity, "pose")
            if entity.kind == "position":
                self._add_movable(entity, pose)
            elif entity.kind == "model" or "bitmap" in entity.properties:
                self._add_model(entity, pose)
                self.add_children(entity, pose)
            elif "pose" in entity.properties:
                self._add_movable(entity, pose)

    def robots(self) -> tuple[list[tuple[float, float]], list[str]]:
        """Return the places of robots, and the types that are not known and not of robots."""
        types = self.robot_types or {kind for kind, _ in self.movable}
        others = dict.fromkeys(kind for kind, _ in self.movable if kind not in types)
        return [place for kind, place in self.movable if kind in types], [*others][:MAX_TYPES_TOLD]

    def _add_movable(self, entity: Entity, pose: _Pose) -> None:
        self.movable.append((entity.kind, (pose.x, pose.y)))
        equipped = any(child.kind != "block" for child in entity.children)
        if entity.kind == "position" or equipped or OF_ROBOTS & entity.properties.keys():
            self.robot_types.add(entity.kind)

    def free(self) -> BaseGeometry:
        """Return free space."""
        if len(self.floorplans) == 1:
            (one,) = self.floorplans
            free = one.pose.place(one.free)
            require_few_overlaps(self.path, [free, *self.obstacles])
            return difference_of(free, self.obstacles)
        placed = [plan.pose.place(plan.free) for plan in self.floorplans]
        walls = [plan.pose.place(plan.ground - plan.free) for plan in self.floorplans]
        require_few_overlaps(self.path, [*placed, *walls, *self.obstacles])
        solid = shapely.union_all([*walls, *self.obstacles], grid_size=SNAP_M)
        free = shapely.union_all(placed, grid_size=SNAP_M)
        return shapely.difference(free, solid, grid_size=SNAP_M)

    def _add_model(self, entity: Entity, pose: _Pose) -> None:
        if not _is_solid(entity):
            return
        width, height = self.units.size(entity)
        pose = pose @ self.units.pose(entity, "origin")
        ground = shapely.box(-width / 2, -height / 2, width / 2, height / 2)
        inner = ground
        if _number(entity, "boundary", 0.0):
            inner = ground.buffer(-BOUNDARY_M, join_style="mitre")
        if "bitmap" in entity.properties:
            bitmap = self._bitmap(entity)
            free = _stretched(bitmap.free, width, height)
            cell = width / bitmap.columns, height / bitmap.rows
            require_length(entity.place, "a pixel of the bitmap", min(cell))
            moved_m = straightened(bitmap.free, cell).straightened_m
            self.straightened_m = max(self.straightened_m, moved_m)
            if inner is not ground:
                free = free & inner
            self._count(free)
            self.floorplans.append(_Floorplan(free, ground, pose))
            return
        solid = [_stretched(block, width, height) for block in _blocks(entity, self.units.length)]
        for shape in (*solid, ground - inner):
            self._count(shape)
            self.obstacles.append(pose.place(shape))

    def _count(self, shape: BaseGeometry) -> None:
        self.corners += int(shapely.get_num_coordinates(shape))
        if self.corners > MAX_CORNERS:
            raise MapFormatError(
                f"{self.path}: its models have more than {MAX_CORNERS:,} corners together; "
                "remove some of them"
            )

    def _bitmap(self, entity: Entity) -> _Bitmap:
        """Return a model's bitmap."""
        found = entity.properties["bitmap"]
        file = found.values[0] if len(found.values) == 1 else None
        if not isinstance(file, str) or not file:
            raise MapFormatError(f"{found.place}: bitmap must be the name of an image in quotes")
        if file not in self.bitmaps:
            if len(self.bitmaps) == MAX_BITMAPS:
                raise MapFormatError(
                    f"{found.place}: the world has more than {MAX_BITMAPS} bitmaps; join some"
                )
            self.bitmaps[file] = self._read(file, found.place)
        return self.bitmaps[file]

    def _read(self, file: str, place: str) -> _Bitmap:
        image = named_file(self.path.parent, file, place)
        if image is None:
            raise no_such_file(self.path.parent, file, f"{place} names the bitmap")
        pixels = read_pixels(image)
        self.pixels += pixels.channels.shape[0] * pixels.channels.shape[1]
        if self.pixels > MAX_CELLS:
            raise MapFormatError(
                f"{place}: the bitmaps of the world have more than {MAX_CELLS:,} pixels together"
            )
        first = pixels.channels if pixels.channels.ndim == 2 else pixels.channels[:, :, 0]
        free = first > FREE_SHARE * pixels.full
        rows, columns = np.flatnonzero(~free.all(axis=1)), np.flatnonzero(~free.all(axis=0))
        if rows.size:
            # The light margin around the dark pixels is not part of the model.
            free = free[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
        height, width = free.shape
        polygons = grid_polygons(image, free, 1.0)
        free_space = shapely.transform(polygons, lambda points: points / (width, height) - 0.5)
        return _Bitmap(free_space, height, width)


def _stretched(shape: BaseGeometry, width: float, height: float) -> BaseGeometry:
    return shapely.transform(shape, lambda points: points * (width, height))


def _is_solid(entity: Entity) -> bool:
    """Return whether robots or range finders detect a model."""
    if _number(entity, "obstacle_return", 1.0) != 0:
        return True
    if "ranger_return" in entity.properties:
        return _number(entity, "ranger_return", 1.0) >= 0
    return _number(entity, "laser_return", 1.0) != 0


def _blocks(entity: Entity, unit: float) -> Iterable[BaseGeometry]:
    """Return the polygons of a model without bitmap, in a unit square around the origin."""
    shapes = [_block(child, unit) for child in entity.children if child.kind == "block"]
    if not shapes:
        return () if _number(entity, "noblocks", 0.0) else (shapely.box(-0.5, -0.5, 0.5, 0.5),)
    x0, y0, x1, y1 = shapely.total_bounds(shapes)
    if not min(x1 - x0, y1 - y0) >= MIN_LENGTH_M:
        raise MapFormatError(
            f"{entity.place}: the blocks of {shortened(entity.word)} have no area: they are "
            f"{x1 - x0:g} x {y1 - y0:g} m"
        )
    centre, extent = ((x0 + x1) / 2, (y0 + y1) / 2), (x1 - x0, y1 - y0)
    return shapely.transform(np.array(shapes, object), lambda points: (points - centre) / extent)


def _block(block: Entity, unit: float) -> Polygon:
    count = _number(block, "points", 0.0)
    if not (count.is_integer() and 3 <= count <= len(block.properties)):
        raise MapFormatError(
            f"{block.place}: a block has points N, at least 3, and point[0] to point[N-1]"
        )
    points = []
    for number in range(int(count)):
        point = _numbers(block, f"point[{number}]", (2,), "[x y]")
        if point is None:
            raise MapFormatError(f"{block.place}: the block has no point[{number}]")
        points.append((unit * point[0], unit * point[1]))
        if max(map(abs, points[-1])) > MAX_COORDINATE_M:
            raise MapFormatError(f"{block.place}: point[{number}] is beyond {MAX_COORDINATE_M:g} m")
    polygon = without_denormals(Polygon(points))
    if not polygon.is_valid:
        raise MapFormatError(
            f"{block.place}: the block is not a valid polygon: {shapely.is_valid_reason(polygon)}"
        )
    return polygon


_WORD: Final = r"[A-Za-z][\w.-]*(?:\[\d+\])?"
_ITEM: Final = re.compile(
    rf"""\s*(?: \) | define\s+{_WORD}\s+{_WORD}\s*\( | {_WORD}\s*\( | {_WORD}\s*"[^"\r\n]*"
    | {_WORD}\s*\[[^\[\]()]*\] | {_WORD}\s+[+-]?\.?\d[\w.+-]* )""",
    re.VERBOSE | re.ASCII,
)
"""A property with its value, the beginning of a model, or the end of one."""

_OF_WORLDS: Final = re.compile(
    r'\bbitmap\s+"|^\s*include\s+"|^\s*define\s+[\w.-]+\s+[\w.-]+\s*\(', re.MULTILINE
)

ITEMS_TRIED: Final = 8
"""Number of items at the beginning of a file that must have the syntax of Stage."""


def _is_stage(beginning: Beginning) -> bool:
    text = re.sub(r"#[^\r\n]*", "", beginning.text)
    at = 0
    for _ in range(ITEMS_TRIED):
        if (item := _ITEM.match(text, at)) is None:
            break
        at = item.end()
    else:
        return _OF_WORLDS.search(text) is not None
    return not text[at:].strip() and _OF_WORLDS.search(text) is not None


STAGE = MapFormat(
    name="Stage world",
    suffixes=(".world",),
    recognises=_is_stage,
    read=read_stage,
)
