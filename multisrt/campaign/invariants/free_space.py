"""Space that robots take as free is free, and was visible from the place of its scan."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.campaign.bodies import FloatArray
from multisrt.campaign.judged_run import JudgedRun
from multisrt.campaign.lasers import DETAIL_M
from multisrt.campaign.violations import Violation
from multisrt.events import NodeAdded
from multisrt.geometry.regions.overlay import GRID_M
from multisrt.spec import RobotSpec

NAME: Final = "known-free-is-free"

TOLERANCE_M: Final = 1e-5
"""Maximum depth of a region in an obstacle, or out of sight, in metres."""

AT_RANGE: Final = "1"
"""Tag of pieces of a border that lie at the range."""

AT_RANGE_M: Final = 1e-6
"""Maximum distance of the corners of such pieces from the range, in metres."""

RANGE_M: Final = 1e-3
"""Maximum reach of a region beyond the range, in metres."""


def known_free_is_free(run: JudgedRun) -> Violation | None:
    """Check that recorded regions lie in the true free space and are visible from their scan.

    Every region is star-shaped about the place of its scan, to 1e-5 m, so all of it was visible. It
    lies within the range of the range finder, to 1e-3 m, and in free space enlarged by 1e-5 m.
    With a laser it may also contain details of obstacles of up to 0.01 m, and, in a world with
    obstacles thinner than the distance between beams or with sharp corners, obstacles that the
    beams missed: those whose distance from free space is at most half the distance between two
    beams at full range. Where the region of an exact range finder ends as out of range, it does so
    at the range, to 1e-6 m. Robots fill their rasters with these regions and with those received
    from others, so nothing else is taken as free.

    Cost: one test for each region; a few milliseconds per run.
    """
    robots = run.recording.spec.robots
    spaces: dict[float, BaseGeometry] = {}
    for node in run.recording.of(NodeAdded):
        spec = robots[node.robot]
        corners = run.recording.region(node)
        wrong = _not_seen(corners, node, spec)
        if wrong is None:
            slack_m = _slack_m(spec, found=run.beams_find_all)
            if slack_m not in spaces:
                spaces[slack_m] = run.environment.free.buffer(slack_m)
                shapely.prepare(spaces[slack_m])
            wrong = _not_free(run, node, spaces[slack_m])
        if wrong is not None:
            return Violation(
                invariant=NAME,
                says=f"the region of node {node.serial} of robot {node.robot} at "
                f"({node.configuration[0]:.3f}, {node.configuration[1]:.3f}), "
                f"{node.time_s:.2f} s, {wrong}",
                robot=node.robot,
                time_s=node.time_s,
            )
    return None


def _slack_m(spec: RobotSpec, *, found: bool) -> float:
    finder = spec.range_finder
    if finder.beams is None:
        return TOLERANCE_M
    return DETAIL_M if found else TOLERANCE_M + finder.range_m * math.pi / finder.beams


def _not_seen(corners: FloatArray, node: NodeAdded, spec: RobotSpec) -> str | None:
    arms = corners - np.array(node.configuration[:2])
    following = np.roll(arms, -1, axis=0)
    farthest_m = float(np.hypot(*arms.T).max())
    at_range = np.frombuffer(node.tags.encode(), np.uint8) == ord(AT_RANGE)
    if spec.range_finder.beams is None and at_range.any():
        ends_m = np.hypot(*arms[at_range].T), np.hypot(*np.roll(arms, -1, axis=0)[at_range].T)
        nearest_m = float(np.minimum(*ends_m).min())
        if nearest_m < spec.range_finder.range_m - AT_RANGE_M:
            return f"ends at {nearest_m:.3f} m as out of range, {spec.range_finder.range_m:g} m"
    if farthest_m > spec.range_finder.range_m + RANGE_M:
        return f"reaches {farthest_m:.3f} m, beyond the range of {spec.range_finder.range_m:g} m"
    # Seen from the place the corners follow one another counter-clockwise, once around.
    lengths = np.hypot(*arms.T), np.hypot(*following.T)
    areas = arms[:, 0] * following[:, 1] - arms[:, 1] * following[:, 0]
    back = -areas / np.maximum(np.maximum(*lengths), TOLERANCE_M)
    if float(back.max()) > TOLERANCE_M:
        x, y = corners[int(np.argmax(back))].tolist()
        return f"is not in sight as a whole: its border turns back at ({x:.3f}, {y:.3f})"
    turned = float(np.arctan2(areas, (arms * following).sum(axis=1)).sum())
    if abs(turned - 2.0 * math.pi) > 1e-3 and float(np.minimum(*lengths).min()) > TOLERANCE_M:
        return f"covers {math.degrees(turned):.1f} degrees around its place instead of 360"
    return None


def _not_free(run: JudgedRun, node: NodeAdded, space: BaseGeometry) -> str | None:
    region = run.regions[node.robot, node.serial]
    if shapely.covers(space, region):
        return None
    beyond = shapely.difference(shapely.make_valid(region), space, grid_size=GRID_M)
    pieces = [piece for piece in shapely.get_parts(beyond) if piece.area > TOLERANCE_M**2]
    if not pieces:
        return None
    largest = max(pieces, key=lambda piece: float(piece.area))
    x, y = largest.representative_point().coords[0]
    return f"contains {beyond.area:.6f} m2 of obstacles, e.g. at ({x:.3f}, {y:.3f})"
