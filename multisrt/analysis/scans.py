"""The area that the scans of a run showed, computed again from the places where they were taken."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from multisrt.environments.environment import Environment
from multisrt.events import NodeAdded, Pose, Sensed
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import ClearanceError, InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.visibility import visibility_polygons
from multisrt.recording import Recording
from multisrt.simulation.sensing import measured
from multisrt.spec import RobotSpec


def scanned_regions(recording: Recording, environment: Environment) -> list[FloatArray]:
    """Return what each scan of a run showed, whatever the robot did with it.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment
        The world in which it was made.

    Returns
    -------
    list of (n, 2) array
        For each event `Sensed`, in the order of the recording, the corners in metres of the
        visibility polygon, cut at the range; of a laser, of the polygon that its beams span
        conservatively (the radial safe region). A laser of less than 5 beams spans nothing: no
        corners.

    Raises
    ------
    InvalidInputError
        If the recording has nodes but no scans, or a scan was not taken in free space.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, RunSpec, simulate
    >>> recording = simulate(RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1))
    >>> shown = scanned_regions(recording, recording.environment())
    >>> len(shown) == len(recording.of(Sensed)), shown[0].shape[1]
    (True, 2)
    """
    scans = recording.of(Sensed)
    if not scans and recording.of(NodeAdded):
        raise InvalidInputError(
            "the recording has nodes but no scans ('sensed'), so that what its robots saw cannot "
            "be judged; run its spec again"
        )
    robots = recording.spec.robots
    # The same index as in the simulation, so that the polygons are the same to the last bit.
    index = EdgeIndex(environment.edges, max(robot.range_finder.range_m for robot in robots) / 3.0)
    of_robot: dict[int, list[int]] = defaultdict(list)
    for number, scan in enumerate(scans):
        of_robot[scan.robot].append(number)
    shown = [np.empty((0, 2))] * len(scans)
    for robot, numbers in of_robot.items():
        try:
            places = [scans[number].configuration for number in numbers]
            regions = shown_from(index, robots[robot], places)
        except ClearanceError as error:
            raise InvalidInputError(
                f"a scan of the recording was not taken in free space: {error}"
            ) from None
        for number, region in zip(numbers, regions, strict=True):
            shown[number] = region
    return shown


def shown_from(index: EdgeIndex, robot: RobotSpec, places: Sequence[Pose]) -> list[FloatArray]:
    """Return what the range finder of a robot shows from some places; see `scanned_regions`."""
    finder = robot.range_finder
    if finder.beams is None:
        return visibility_polygons(index, np.array(places)[:, :2], finder.range_m)
    scans = (measured(robot, index, Configuration(*place), math.nan) for place in places)
    return [local_safe_region(scan, "radial").boundary for scan in scans]
