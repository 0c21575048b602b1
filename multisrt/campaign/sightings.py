"""Robots see the bodies that are in sight, where these are, and no others."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.campaign.judged_run import ROUNDING_M, JudgedRun
from multisrt.campaign.violations import Violation
from multisrt.robots.explorer import Sighting

NAME: Final = "bodies-in-sight"

MAX_LOOKS: Final = 100
"""Number of looks of a run that are judged; of more, these are spread over the run."""

ROUNDING_RAD: Final = 1e-6
"""Headings that differ by less are equal, in radians."""

Place = tuple[float, float]


class Looked(NamedTuple):
    """What a robot saw at a time."""

    robot: int
    time_s: float
    seen: tuple[Sighting, ...]


def bodies_in_sight(run: JudgedRun, looks: Sequence[Looked]) -> Iterator[Violation]:
    """Yield the first look of a run that shows other bodies than are in sight.

    A robot is in sight if its body is no farther than the range from the reference point of the
    one that looks, and the line between the two reference points lies in free space: in that
    enlarged by 1e-6 m for those that are seen, in that reduced by 1e-6 m for those that must be.
    Bodies are where the recorded motions are at that time, to 1e-6 m and 1e-6 rad.

    Parameters
    ----------
    run : JudgedRun
        The run.
    looks : sequence of Looked
        All looks of its robots.
    """
    step = math.ceil(len(looks) / MAX_LOOKS) if looks else 1
    grown, inner = run.walls.grown, None
    for look in looks[::step]:
        seen = {sighting.robot: sighting for sighting in look.seen}
        at = np.array([look.time_s])
        poses = [track.at(at) for track in run.tracks]
        here = _place(poses[look.robot])
        range_m = run.recording.spec.robots[look.robot].range_finder.range_m
        for other in run.robots:
            if other == look.robot:
                continue
            there = _place(poses[other])
            body, reference = run.bodies[other], shapely.Point(here)
            away_m = body.at(poses[other])[0].distance(reference) - body.radius_m
            if other in seen:
                where, pose = seen[other].configuration, poses[other][0]
                turned = math.remainder(where.heading - pose[2], math.tau)
                if math.dist((where.x, where.y), there) > ROUNDING_M or abs(turned) > ROUNDING_RAD:
                    yield _violation(look, other, "where it is not")
                if away_m > range_m + ROUNDING_M:
                    yield _violation(look, other, f"{away_m:.3f} m away, out of range")
                if not _is_free(here, there, grown):
                    yield _violation(look, other, "through a wall")
            elif away_m < range_m - ROUNDING_M:
                if inner is None:
                    inner = run.once("shrunk", run.walls.shrunk)
                if _is_free(here, there, inner):
                    yield _violation(look, other, "which is in sight", sees="does not see")


def _place(pose: np.ndarray) -> Place:
    x, y, _ = pose[0].tolist()
    return x, y


def _is_free(here: Place, there: Place, free: BaseGeometry) -> bool:
    return bool(shapely.covers(free, shapely.LineString([here, there])))


def _violation(look: Looked, other: int, says: str, sees: str = "sees") -> Violation:
    return Violation(
        invariant=NAME,
        says=f"robot {look.robot} {sees} robot {other} {says}, at {look.time_s:.2f} s",
        robot=look.robot,
        time_s=look.time_s,
    )
