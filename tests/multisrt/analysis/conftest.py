"""Recordings and events by hand, in a hall of 10 x 10 m unless another world is given."""

from collections.abc import Callable, Sequence

import pytest
import shapely

from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent, Died, Learned, Motion, NodeAdded, Sensed, Sent, Stage
from multisrt.geometry.configuration import Configuration
from multisrt.recording import Recorder, Recording, header_of
from multisrt.simulation.worlds import inline
from multisrt.spec import Fault, RadioSpec, RangeFinderSpec, RobotSpec, RunSpec

HALL = Environment("hall", shapely.box(0, 0, 10, 10))


@pytest.fixture(scope="session")
def hall() -> Environment:
    """The hall."""
    return HALL


@pytest.fixture(scope="session")
def recorded() -> Callable[..., Recording]:
    """Build a recording of a team, or of one robot at (1, 1)."""

    def build(
        *events: AnyEvent,
        starts: Sequence[tuple[float, ...]] = ((1.0, 1.0, 0.0),),
        footprints: Sequence[str] | None = None,
        range_m: float = 20.0,
        world: Environment = HALL,
        radio: RadioSpec | None = None,
        faults: tuple[Fault, ...] = (),
        end_s: float = 50.0,
        scans: bool = True,
    ) -> Recording:
        robots = tuple(
            RobotSpec(start=start, footprint=body, range_finder=RangeFinderSpec(range_m=range_m))
            for start, body in zip(starts, footprints or ["disc:0.25"] * len(starts), strict=True)
        )
        spec = RunSpec(
            environment=inline(world), robots=robots, radio=radio or RadioSpec(), faults=faults
        )
        at = tuple(Configuration(*start) for start in starts)
        recorder = Recorder(header_of(spec, world, at))
        # Robots see before they note: from where nodes are, which shows all of the hall.
        with_nodes = dict.fromkeys(e.robot for e in events if isinstance(e, NodeAdded))
        for robot in with_nodes if scans else ():
            recorder.record(Sensed(time_s=0.0, robot=robot, configuration=(1.0, 1.0, 0.0)))
        for event in events:
            if isinstance(event, Learned):
                # Who made a node has told of it.
                for maker, _ in event.nodes:
                    told = Sent(
                        time_s=event.time_s, robot=maker, kind="map", size_bytes=0,
                        reached=(event.robot,),
                    )  # fmt: skip
                    recorder.record(told)
            recorder.record(event)
        return recorder.finish(end_s, "complete", "")

    return build


@pytest.fixture(scope="session")
def moved() -> Callable[..., Motion]:
    """Build a motion through waypoints, each a time and a configuration."""

    def build(*waypoints: tuple[float, float, float, float], robot: int = 0) -> Motion:
        return Motion(time_s=waypoints[0][0], robot=robot, waypoints=waypoints)

    return build


@pytest.fixture(scope="session")
def seen() -> Callable[..., NodeAdded]:
    """Build a node whose region is a polygon, without any frontier."""

    def build(
        time_s: float,
        polygon: shapely.Polygon,
        stage: Stage = "draw",
        serial: int = 0,
        robot: int = 0,
    ) -> NodeAdded:
        ring = shapely.orient_polygons(polygon).exterior
        corners = tuple((x, y) for x, y in list(ring.coords)[:-1])
        return NodeAdded(
            time_s=time_s,
            robot=robot,
            serial=serial,
            parent=None,
            configuration=(1.0, 1.0, 0.0),
            stage=stage,
            boundary=corners,
            tags="0" * len(corners),
        )

    return build


@pytest.fixture(scope="session")
def died() -> Callable[[float, int], Died]:
    """Build the death of a robot at a time, by its number."""

    def build(time_s: float, robot: int) -> Died:
        return Died(time_s=time_s, robot=robot, configuration=(1.0, 1.0, 0.0), doing="waiting")

    return build
