"""Robots see the bodies that are in sight, as and where these are, and no others."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.campaign.bodies import FloatArray
from multisrt.campaign.judged_run import ROUNDING_M, ROUNDING_S, JudgedRun
from multisrt.campaign.violations import Violation
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.robots.explorer import Moved, Sighting

NAME: Final = "bodies-in-sight"

ROUNDING_RAD: Final = 1e-6
"""Headings that differ by less are equal, in radians."""

Place = tuple[float, float]


class Looked(NamedTuple):
    """What a robot saw at a time."""

    robot: int
    time_s: float
    seen: tuple[Sighting, ...]


class EndOfMotion(NamedTuple):
    """What a robot was told at the end of a motion, and which body stopped it, as recorded."""

    robot: int
    time_s: float
    moved: Moved
    by: int | None


def bodies_in_sight(run: JudgedRun, looks: Sequence[Looked]) -> Iterator[Violation]:
    """Yield looks of a run that show other bodies than are in sight.

    A robot is in sight if its body is no farther than the range from the reference point of the
    one that looks, and the line between the two reference points lies in free space: in that
    enlarged by 1e-6 m for those that are seen, in that reduced by 1e-6 m for those that must be.
    Bodies are as the spec says, and where the recorded motions are at that time, to 1e-6 m and 1e-6
    rad.

    Parameters
    ----------
    run : JudgedRun
        The run.
    looks : sequence of Looked
        Looks of its robots.
    """
    grown, inner = run.walls.grown, None
    for look in looks:
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
                flaw = _flaw(run, seen[other], poses[other][0])
                if flaw is not None:
                    yield _violation(look, other, flaw)
                if away_m > range_m + ROUNDING_M:
                    yield _violation(look, other, f"{away_m:.3f} m away, out of range")
                if not _is_free(here, there, grown):
                    yield _violation(look, other, "through a wall")
            elif away_m < range_m - ROUNDING_M:
                if inner is None:
                    inner = run.once("shrunk", run.walls.shrunk)
                if _is_free(here, there, inner):
                    yield _violation(look, other, "which is in sight", sees="does not see")


def ends_of_motions(run: JudgedRun, ends: Sequence[EndOfMotion]) -> Iterator[Violation]:
    """Yield ends of motions of which a robot is told something else than happens.

    It is told where it is, to 1e-6 m and 1e-6 rad, and when; and of a motion that another body
    stopped, by the record, that body, as and where it is.

    Parameters
    ----------
    run : JudgedRun
        The run.
    ends : sequence of EndOfMotion
        Ends of motions of its robots.
    """
    for robot, time_s, moved, by in ends:
        poses = [track.at(np.array([time_s]))[0] for track in run.tracks]
        told, says = moved.blocked_by, None
        if abs(moved.time_s - time_s) > ROUNDING_S:
            says = f"at {moved.time_s:.3f} s"
        elif not _is_at(moved.configuration, poses[robot]):
            says = "where it is not"
        elif (told is None) != (by is None) or (told is not None and told.robot != by):
            says = f"by {_named(None if told is None else told.robot)}, and not {_named(by)}"
        elif told is not None and (flaw := _flaw(run, told, poses[told.robot])) is not None:
            says = f"by {_named(told.robot)} {flaw}"
        if says is not None:
            yield Violation(
                invariant=NAME,
                says=f"robot {robot} is told of the end of its motion at {time_s:.2f} s {says}",
                robot=robot,
                time_s=time_s,
            )


def _named(robot: int | None) -> str:
    return "nobody" if robot is None else f"robot {robot}"


def _flaw(run: JudgedRun, seen: Sighting, pose: FloatArray) -> str | None:
    if not _is_at(seen.configuration, pose):
        return "where it is not"
    footprint = Footprint.parse(run.recording.spec.robots[seen.robot].footprint)
    return None if str(seen.footprint) == str(footprint) else "as another body"


def _is_at(told: Configuration, pose: FloatArray) -> bool:
    x, y, heading = pose.tolist()
    turned = math.remainder(told.heading - heading, math.tau)
    return math.dist((told.x, told.y), (x, y)) <= ROUNDING_M and abs(turned) <= ROUNDING_RAD


def _place(pose: FloatArray) -> Place:
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
