"""A run as an MCAP file with topics of ROS 2."""

from __future__ import annotations

from collections.abc import Iterable
from typing import IO, Final, assert_never

import msgspec
import numpy as np

from multisrt.exporting import ros_messages as ros
from multisrt.exporting.contents import (
    Body,
    Content,
    Covered,
    KnownMap,
    Links,
    Placed,
    Said,
    State,
    Tree,
    Truth,
    Way,
)
from multisrt.exporting.grids import Grid
from multisrt.exporting.looks import (
    FRONTIER,
    LINK,
    body_colour,
    colour_of,
    outline_of,
    triangles_of,
)
from multisrt.exporting.mcap_file import McapFile, Topic
from multisrt.exporting.moments import Moment
from multisrt.exporting.sampling import nanoseconds
from multisrt.recording import Recording

TRUTH: Final = Topic("/truth/map", "nav_msgs/OccupancyGrid", latched=True)
TF: Final = Topic("/tf", "tf2_msgs/TFMessage")
LINKS: Final = Topic("/links", "visualization_msgs/MarkerArray")
LOG: Final = Topic("/rosout", "rcl_interfaces/Log")
COVERAGE: Final = Topic("/coverage", "std_msgs/Float64")
SEEN: Final = Topic("/seen", "std_msgs/Float64")

LINK_M, EDGE_M, TREE_NODE_M = 0.03, 0.05, 0.15
"""Width of lines, and diameter of nodes, in metres."""

LINK_HEIGHT_M, TREE_HEIGHT_M, FRONTIER_HEIGHT_M, BODY_HEIGHT_M = 0.02, 0.04, 0.06, 0.1
"""Heights above the map in metres: higher elements cover lower ones."""

LABEL_HEIGHT_M: Final = 0.4
"""Height of the letters of the number of a robot, in metres."""


def write_mcap(
    file: IO[bytes], recording: Recording, grid: Grid, contents: Iterable[Moment]
) -> None:
    """Write a run as MCAP.

    Parameters
    ----------
    file : binary file
        File to write to.
    recording : Recording
        The run.
    grid : Grid
        The lattice of its maps.
    contents : iterable of Moment
        Its contents, in order of time.

    Raises
    ------
    MissingExtraError
        If mcap is not installed.
    """
    bag = McapFile(file)
    scene = _Scene(recording, grid)
    for now, content in contents:
        for topic, message in scene.messages(now, content):
            bag.write(topic, now, message)
    bag.close(
        {
            "spec": msgspec.json.encode(recording.spec).decode(),
            "world": recording.header.world,
            "outcome": recording.footer.outcome,
            "reason": recording.footer.reason,
            "digest": recording.footer.digest,
        }
    )


class _Scene:
    """The messages of a run."""

    def __init__(self, recording: Recording, grid: Grid) -> None:
        self._grid = grid
        self._outlines = [outline_of(robot.footprint) for robot in recording.spec.robots]

    def messages(self, now: int, content: Content) -> list[tuple[Topic, bytes]]:
        """Return the messages of a content with their topics."""
        match content:
            case Placed(robot=robot, pose=pose):
                frame = f"robot_{robot}/base_link"
                pose_topic = _topic(robot, "pose", "geometry_msgs/PoseStamped")
                return [
                    (TF, ros.transform(now, pose, frame)),
                    (pose_topic, ros.pose_stamped(now, pose)),
                ]
            case Truth(cells=cells):
                return [(TRUTH, ros.occupancy_grid(now, self._grid, cells))]
            case KnownMap(robot=robot):
                return self._map(now, content)
            case Tree(robot=robot):
                markers = self._tree(content)
                return [(_markers(robot, "tree"), ros.marker_array(now, markers))]
            case Body(robot=robot, state=state):
                markers = self._body(robot, state)
                return [(_markers(robot, "body", latched=True), ros.marker_array(now, markers))]
            case Way(robot=robot, points=points):
                stamps = [nanoseconds(time_s) for time_s in points[:, 0].tolist()]
                poses = [(x, y, heading) for x, y, heading in points[:, 1:].tolist()]
                topic = _topic(robot, "path", "nav_msgs/Path")
                return [(topic, ros.path(now, stamps, poses))]
            case Links(lines=lines):
                marker = ros.Marker(
                    namespace="links",
                    kind=ros.LINE_LIST,
                    points=lines.reshape(-1, 2),
                    colour=LINK,
                    width_m=LINK_M,
                    height_m=LINK_HEIGHT_M,
                )
                return [(LINKS, ros.marker_array(now, [marker]))]
            case Said(robot=robot, text=text, is_trouble=is_trouble):
                level = ros.WARN if is_trouble else ros.INFO
                return [(LOG, ros.log(now, level, f"robot_{robot}", text))]
            case Covered(coverage=coverage, seen=seen):
                return [(COVERAGE, ros.float64(coverage)), (SEEN, ros.float64(seen))]
        assert_never(content)

    def _map(self, now: int, known: KnownMap) -> list[tuple[Topic, bytes]]:
        topic = _topic(known.robot, "map", "nav_msgs/OccupancyGrid", latched=True)
        marker = ros.Marker(
            namespace="frontier",
            kind=ros.POINTS,
            points=known.frontier,
            colour=FRONTIER,
            width_m=self._grid.cell_m,
            height_m=FRONTIER_HEIGHT_M,
        )
        return [
            (topic, ros.occupancy_grid(now, self._grid, known.cells)),
            (_markers(known.robot, "frontier"), ros.marker_array(now, [marker])),
        ]

    def _tree(self, tree: Tree) -> list[ros.Marker]:
        colour = colour_of(tree.robot)
        edges = ros.Marker(
            namespace="edges",
            kind=ros.LINE_LIST,
            points=tree.edges.reshape(-1, 2),
            colour=colour,
            width_m=EDGE_M,
            height_m=TREE_HEIGHT_M,
        )
        nodes = ros.Marker(
            namespace="nodes",
            kind=ros.SPHERES,
            points=tree.nodes,
            colour=colour,
            width_m=TREE_NODE_M,
            height_m=TREE_HEIGHT_M,
        )
        return [edges, nodes]

    def _body(self, robot: int, state: State) -> list[ros.Marker]:
        outline = self._outlines[robot]
        frame = f"robot_{robot}/base_link"
        front = np.array([(0.0, 0.0), (outline[:, 0].max(), 0.0)])
        body = ros.Marker(
            namespace="body",
            kind=ros.TRIANGLES,
            points=triangles_of(outline),
            colour=body_colour(robot, state),
            width_m=0.0,
            height_m=BODY_HEIGHT_M,
            frame=frame,
            locked=True,
        )
        heading = ros.Marker(
            namespace="heading",
            kind=ros.LINE_LIST,
            points=front,
            colour=(1.0, 1.0, 1.0, 1.0),
            width_m=EDGE_M,
            height_m=BODY_HEIGHT_M + 0.01,
            frame=frame,
            locked=True,
        )
        label = ros.Marker(
            namespace="number",
            kind=ros.TEXT,
            points=np.zeros((1, 2)),
            colour=(0.0, 0.0, 0.0, 1.0),
            width_m=LABEL_HEIGHT_M,
            height_m=BODY_HEIGHT_M + LABEL_HEIGHT_M,
            frame=frame,
            locked=True,
            text=str(robot),
        )
        return [body, heading, label]


def _topic(robot: int, name: str, kind: str, *, latched: bool = False) -> Topic:
    return Topic(f"/robot_{robot}/{name}", kind, latched)


def _markers(robot: int, name: str, *, latched: bool = False) -> Topic:
    return _topic(robot, name, "visualization_msgs/MarkerArray", latched=latched)
