"""A run as a rerun file, on the timeline `sim_time`."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, assert_never
from uuid import NAMESPACE_URL, uuid5

import numpy as np
import shapely

from multisrt.environments.environment import Environment
from multisrt.events import Pose
from multisrt.exporting.contents import (
    Body,
    Content,
    Covered,
    KnownMap,
    Links,
    Placed,
    Said,
    Tree,
    Truth,
    Way,
)
from multisrt.exporting.grids import Cells, Grid
from multisrt.exporting.looks import (
    FRONTIER,
    LINK,
    body_colour,
    colour_of,
    outline_of,
    triangles_of,
)
from multisrt.exporting.moments import Moment
from multisrt.extras import extra
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.recording import Recording

if TYPE_CHECKING:
    from rerun import RecordingStream
    from rerun.blueprint import Blueprint

APPLICATION: Final = "multisrt"
TIME_LINE: Final = "sim_time"

MAX_MAP_VIEWS: Final = 16
"""Maximum number of robots whose maps have views of their own."""

LINE_M, NODE_M = 0.06, 0.15
"""Radius of lines and of nodes, in metres."""

LINK_HEIGHT_M, TREE_HEIGHT_M, FRONTIER_HEIGHT_M, BODY_HEIGHT_M = 0.02, 0.04, 0.06, 0.1
"""Heights above the map in metres: higher elements cover lower ones."""

FLUSH_S: Final = 1e9
"""Time after which an incomplete chunk is written, in seconds: practically never."""

BATCH: Final = 4096
"""Number of poses of a robot that are written at once."""


def write_rerun(
    path: Path,
    recording: Recording,
    environment: Environment,
    grid: Grid,
    contents: Iterable[Moment],
) -> None:
    """Write a run as a rerun file, without starting a viewer or sending anything.

    Parameters
    ----------
    path : Path
        File to write to.
    recording : Recording
        The run.
    environment : Environment
        Its world.
    grid : Grid
        The lattice of its maps.
    contents : iterable of Moment
        Its contents, in order of time.

    Raises
    ------
    MissingExtraError
        If rerun-sdk is not installed.
    InvalidInputError
        If the environment variable ``RERUN`` turns its recording off.
    OSError
        If the file cannot be written.
    """
    with extra("rerun", "a file of rerun"):
        import rerun as rr
    # Chunks end only by size. Properties are left out, since they hold the date.
    batches = rr.ChunkBatcherConfig.DEFAULT()
    batches.flush_tick = FLUSH_S
    stream = rr.RecordingStream(
        APPLICATION,
        recording_id=uuid5(NAMESPACE_URL, recording.footer.digest),
        send_properties=False,
        batcher_config=batches,
    )
    try:
        if not rr.is_enabled(stream):
            raise InvalidInputError(
                "rerun is turned off by the environment variable RERUN: unset it to export"
            )
        stream.set_log_time_enabled(False)
        stream.set_log_tick_enabled(False)
        # Kept in memory, since rerun's own writer may wait for ever when the disk is full.
        memory = stream.memory_recording()
        stream.send_blueprint(_blueprint(recording, environment), make_active=False)
        spec = recording.spec
        stream.send_recording_name(
            f"{spec.strategy} in {environment.name}, {len(spec.robots)} robots, seed {spec.seed}"
        )
        scene = _Scene(stream, recording, environment, grid)
        for now, content in contents:
            scene.show(now, content)
        scene.finish()
        path.write_bytes(memory.drain_as_bytes())
    finally:
        stream.disconnect()


class _Scene:
    """The entities of a run."""

    def __init__(
        self, stream: RecordingStream, recording: Recording, environment: Environment, grid: Grid
    ) -> None:
        import rerun

        self._rr: Any = rerun
        self._stream = stream
        self._grid = grid
        self._poses: dict[int, list[tuple[int, Pose]]] = defaultdict(list)
        self._triangles = [
            _raised(triangles_of(outline_of(robot.footprint)), BODY_HEIGHT_M)
            for robot in recording.spec.robots
        ]
        self._log("/", rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        rings = [
            _raised(shapely.get_coordinates(ring), 0.0)
            for part in environment.free.geoms
            for ring in (part.exterior, *part.interiors)
        ]
        walls = rerun.LineStrips3D(rings, radii=LINE_M, colors=[(26, 26, 26)])
        self._log("world/walls", walls, static=True)

    def show(self, now: int, content: Content) -> None:
        """Write a content, or keep a pose until there are enough of them."""
        rr = self._rr
        if isinstance(content, Placed):
            self._place(now, content)
            return
        self._stream.set_time(TIME_LINE, duration=np.timedelta64(now, "ns"))
        match content:
            case Truth(cells=cells):
                self._log("world/truth", self._grid_map(cells, -0.01), static=True)
            case KnownMap(robot=robot, cells=cells, frontier=frontier):
                self._log(f"robots/{robot}/map", self._grid_map(cells, 0.0))
                points = _raised(frontier, FRONTIER_HEIGHT_M)
                radius = 0.5 * self._grid.cell_m
                shown = rr.Points3D(points, radii=radius, colors=[_bytes(FRONTIER)])
                self._log(f"robots/{robot}/frontier", shown)
            case Tree(robot=robot, nodes=nodes, edges=edges):
                colours = [_bytes(colour_of(robot))]
                lines = _raised(edges.reshape(-1, 2), TREE_HEIGHT_M).reshape(-1, 2, 3)
                shown = rr.LineStrips3D(lines, radii=LINE_M, colors=colours)
                self._log(f"robots/{robot}/tree", shown)
                points = _raised(nodes, TREE_HEIGHT_M)
                shown = rr.Points3D(points, radii=NODE_M, colors=colours)
                self._log(f"robots/{robot}/tree/nodes", shown)
            case Body(robot=robot, state=state):
                self._log(
                    f"robots/{robot}/body", self._body(robot, _bytes(body_colour(robot, state)))
                )
            case Way(robot=robot, points=points):
                way = [_raised(points[:, 1:3], LINK_HEIGHT_M)]
                colours = [_bytes(colour_of(robot))]
                self._log(
                    f"robots/{robot}/path", rr.LineStrips3D(way, radii=LINE_M, colors=colours)
                )
            case Links(lines=links):
                lines = _raised(links.reshape(-1, 2), LINK_HEIGHT_M).reshape(-1, 2, 3)
                self._log("links", rr.LineStrips3D(lines, radii=LINE_M, colors=[_bytes(LINK)]))
            case Said(robot=robot, text=text, is_trouble=is_trouble):
                level = "WARN" if is_trouble else "INFO"
                self._log(f"decisions/{robot}", rr.TextLog(text, level=level))
            case Covered(coverage=coverage, seen=seen):
                self._log("curves/coverage", rr.Scalars(coverage))
                self._log("curves/seen", rr.Scalars(seen))
            case _:
                assert_never(content)

    def finish(self) -> None:
        """Write the poses that were kept."""
        for robot in sorted(self._poses):
            self._send_poses(robot)

    def _log(self, entity: str, shown: Any, *, static: bool = False) -> None:
        parts = entity.strip("/").split("/") if entity != "/" else []
        self._stream.log(list(parts) or "/", shown, static=static, strict=True)

    def _place(self, now: int, placed: Placed) -> None:
        kept = self._poses[placed.robot]
        kept.append((now, placed.pose))
        if len(kept) == BATCH:
            self._send_poses(placed.robot)

    def _send_poses(self, robot: int) -> None:
        rr, kept = self._rr, self._poses[robot]
        times = np.array([now for now, _ in kept], "timedelta64[ns]")
        poses = np.array([pose for _, pose in kept])
        kept.clear()
        half = 0.5 * poses[:, 2]
        turns = np.column_stack([np.zeros((len(half), 2)), np.sin(half), np.cos(half)])
        self._stream.send_columns(
            f"robots/{robot}/body",
            indexes=[rr.TimeColumn(TIME_LINE, duration=times)],
            columns=rr.Transform3D.columns(
                translation=_raised(poses[:, :2], 0.0), quaternion=turns
            ),
            strict=True,
        )

    def _grid_map(self, cells: Cells, height_m: float) -> Any:
        rr, grid = self._rr, self._grid
        return rr.GridMap(
            data=cells[::-1].tobytes(),  # from the top, as images
            format=rr.components.ImageFormat(
                width=grid.columns, height=grid.rows, color_model="L", channel_datatype="U8"
            ),
            cell_size=grid.cell_m,
            translation=[grid.x0, grid.y0, height_m],
            colormap=rr.components.Colormap.RvizMap,
        )

    def _body(self, robot: int, colour: tuple[int, ...]) -> Any:
        corners = self._triangles[robot]
        indices = np.arange(len(corners)).reshape(-1, 3)
        return self._rr.Mesh3D(
            vertex_positions=corners, triangle_indices=indices, albedo_factor=colour
        )


def _blueprint(recording: Recording, environment: Environment) -> Blueprint:
    import rerun.blueprint as rrb

    x0, y0, x1, y1 = environment.bounds
    centre = [0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.0]
    above = [centre[0], centre[1], 1.2 * max(x1 - x0, y1 - y0)]
    robots = range(len(recording.starts))

    def view(name: str, contents: list[str]) -> rrb.Spatial3DView:
        eye = rrb.EyeControls3D(position=above, look_target=centre, eye_up=[0.0, 1.0, 0.0])
        return rrb.Spatial3DView(
            name=name, origin="/", contents=contents, line_grid=False, eye_controls=eye
        )

    hidden = [f"- /robots/{robot}/map" for robot in robots]
    team = view("Team", ["+ /world/**", "+ /robots/**", "+ /links", *hidden])
    maps = [
        view(f"Map of robot {robot}", [f"+ /robots/{robot}/**"]) for robot in robots[:MAX_MAP_VIEWS]
    ]
    return rrb.Blueprint(
        rrb.Vertical(
            rrb.Horizontal(team, rrb.Tabs(*maps)),
            rrb.Horizontal(
                rrb.TimeSeriesView(name="Coverage", origin="/curves"),
                rrb.TextLogView(name="Decisions", origin="/decisions"),
            ),
            row_shares=[3, 1],
        ),
        rrb.TimePanel(timeline=TIME_LINE),
        collapse_panels=True,
    )


def _raised(points: FloatArray, height_m: float) -> FloatArray:
    # Points of the plane at a height, (n, 3).
    return np.column_stack([points, np.full(len(points), height_m)])


def _bytes(colour: Sequence[float]) -> tuple[int, ...]:
    return tuple(round(255 * part) for part in colour)
