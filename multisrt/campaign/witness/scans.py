"""Range finders measure the distances to walls, from where robots are."""

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
from multisrt.geometry.regions.boundary import GAP, OBSTACLE, RANGE
from multisrt.geometry.regions.scan import ExactScan, LaserScan, Scan

NAME: Final = "scans-show-walls"

MAX_BEAMS: Final = 24
"""Number of beams or pieces of a scan that are judged; of more, these are spread over it."""

READING_M: Final = 1e-5
"""Readings that differ by less are equal, in metres."""

ASIDES_RAD: Final = (0.0, 1e-6, -1e-6)
"""A beam that touches a corner may hit it or pass it: beams that point so far aside count, too."""


class Scanned(NamedTuple):
    """What a robot measured at a time."""

    robot: int
    time_s: float
    scan: Scan


def scans_show_walls(run: JudgedRun, scans: Sequence[Scanned]) -> Iterator[Violation]:
    """Yield scans that show something else than walls.

    A scan is of the place where the robot is, to 1e-6 m, and of the range of its range finder. The
    reading of a beam is the distance to the first wall along it, to 1e-5 m, or infinite if there is
    none within range; either counts at 1e-5 m from the range. The border of an exact scan consists
    of walls, of arcs at the range, and of lines of sight past the corners of walls, all to 1e-5 m;
    no wall is before it.

    Parameters
    ----------
    run : JudgedRun
        The run.
    scans : sequence of Scanned
        Scans of its robots.
    """
    border = shapely.boundary(shapely.MultiPolygon(run.environment.free))
    shapely.prepare(border)
    for robot, time_s, scan in scans:
        x, y, _ = run.tracks[robot].pose(time_s)
        where, finder = scan.configuration, run.recording.spec.robots[robot].range_finder
        says = None
        if math.dist((x, y), (where.x, where.y)) > ROUNDING_M:
            says = "is not of where it is"
        elif abs(scan.time_s - time_s) > ROUNDING_S or scan.range_m != finder.range_m:
            says = f"is of {scan.time_s:.3f} s, with a range of {scan.range_m:g} m"
        elif isinstance(scan, ExactScan):
            says = None if finder.beams is None else "has no beams"
            says = says or _wrong_border(scan, border)
        elif len(scan.ranges) != finder.beams:
            says = f"has {len(scan.ranges)} beams"
        else:
            says = _wrong_beam(scan, border)
        if says is not None:
            yield Violation(
                invariant=NAME,
                says=f"a scan of robot {robot} at {time_s:.2f} s {says}",
                robot=robot,
                time_s=time_s,
            )


def _wrong_beam(scan: LaserScan, border: BaseGeometry) -> str | None:
    beams = len(scan.ranges)
    for beam in np.unique(np.linspace(0, beams - 1, min(beams, MAX_BEAMS)).astype(int)).tolist():
        reading_m, angle = float(scan.ranges[beam]), math.tau * beam / beams
        if not any(_agrees(scan, angle + aside, reading_m, border) for aside in ASIDES_RAD):
            true_m = _distance(scan, angle, border)
            return (
                f"reads {reading_m:.4f} m at {angle:.3f} rad, where a wall is {true_m:.4f} m away"
            )
    return None


def _agrees(scan: LaserScan, angle: float, reading_m: float, border: BaseGeometry) -> bool:
    true_m = _distance(scan, angle, border)
    if math.isinf(reading_m):
        return true_m > scan.range_m - READING_M
    return abs(true_m - reading_m) <= READING_M


def _distance(scan: Scan, angle: float, border: BaseGeometry) -> float:
    # To the first wall in a direction; inf beyond a little more than the range.
    x, y, _ = scan.configuration
    far_m = scan.range_m + 2.0 * READING_M
    there = x + far_m * math.cos(angle), y + far_m * math.sin(angle)
    hits = shapely.intersection(shapely.LineString([(x, y), there]), border)
    return math.inf if hits.is_empty else float(hits.distance(shapely.Point(x, y)))


def _wrong_border(scan: ExactScan, border: BaseGeometry) -> str | None:
    ends: FloatArray = np.stack([scan.boundary, np.roll(scan.boundary, -1, axis=0)], axis=1)
    pieces = np.linspace(0, len(ends) - 1, min(len(ends), MAX_BEAMS)).astype(int)
    for piece in np.unique(pieces).tolist():
        wrong = _wrong_piece(scan, ends[piece], int(scan.tags[piece]), border)
        if wrong is not None:
            return f"{wrong} at ({ends[piece, 0, 0]:.3f}, {ends[piece, 0, 1]:.3f})"
    return None


def _wrong_piece(scan: ExactScan, ends: FloatArray, tag: int, border: BaseGeometry) -> str | None:
    x, y, _ = scan.configuration
    (ax, ay), (bx, by) = (ends - (x, y)).tolist()
    away_m, beyond_m = math.hypot(ax, ay), math.hypot(bx, by)
    if tag == GAP:
        if abs(ax * by - ay * bx) > READING_M * max(away_m, beyond_m):
            return "has a gap that is not on a line of sight"
        corner = shapely.Point(ends[0] if away_m < beyond_m else ends[1])
        return None if border.distance(corner) <= READING_M else "has a gap at no corner"
    middle = ends.mean(axis=0)
    if tag == OBSTACLE and border.distance(shapely.Point(middle)) > READING_M:
        return "has a wall where there is none"
    if tag == RANGE and max(abs(away_m - scan.range_m), abs(beyond_m - scan.range_m)) > READING_M:
        return f"ends {away_m:.4f} m away, where there is no wall,"
    there_m = math.hypot(*(middle - (x, y)))
    angle = math.atan2(middle[1] - y, middle[0] - x)
    if all(_distance(scan, angle + a, border) < there_m - READING_M for a in ASIDES_RAD):
        return "sees through a wall"
    return None
