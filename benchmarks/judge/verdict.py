"""What the package measured of a run beside what the judge did, and what may differ."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely

from benchmarks.judge.areas import KNOWN, Areas, World, areas
from benchmarks.judge.links import STEP_S, Links, links
from benchmarks.judge.motions import between_robots_m, clearance_m
from multisrt.analysis.coverage import coverage
from multisrt.analysis.evidence import evidence
from multisrt.analysis.explorable import explorable, viewers
from multisrt.analysis.measuring import measure
from multisrt.analysis.metrics import Metrics
from multisrt.campaign.tracks import Track, tracks
from multisrt.environments.environment import Environment
from multisrt.recording import Recording

AREA: Final = 1e-4
"""Maximum error of an area, as a share of what is explorable."""

TIME_S: Final = 0.5
"""Maximum error of a time at which a share is reached."""

GAP_M: Final = 1e-4
"""Maximum error of a clearance, or of a distance between robots."""

LENGTH: Final = 1e-6
"""Maximum relative error of a distance driven."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """A figure of one run.

    Attributes
    ----------
    name : str
        Which one.
    ours : float
        What the package measured; nan where it has none.
    judged : float
        What the judge measured.
    difference : float
        By how much they differ; inf where only one of them has a value.
    allowed : float
        By how much they may.
    """

    name: str
    ours: float
    judged: float
    difference: float
    allowed: float

    @property
    def holds(self) -> bool:
        """Whether the difference is allowed."""
        return self.difference <= self.allowed


def judge(recording: Recording, world: Environment, part: World) -> list[Figure]:
    """Measure a run twice, and return all figures.

    Parameters
    ----------
    recording : Recording
        The run.
    world : Environment
        Its world.
    part : World
        The connected part of it in which the team is, as the judge sees it.
    """
    ours, judged = measure(recording, world), areas(recording, part)
    return [
        *_areas(ours, judged),
        _curve(recording, world, judged),
        *_motions(ours, recording, world),
    ]


def part_of(recording: Recording) -> shapely.Polygon:
    """Return the connected part of free space around the starts of a run."""
    x, y, _ = recording.header.starts[0]
    here = shapely.Point(x, y)
    parts = (shapely.Polygon(rings[0], rings[1:]) for rings in recording.header.free)
    return next(part for part in parts if part.contains(here))


def _areas(ours: Metrics, judged: Areas) -> list[Figure]:
    whole, end_s = judged.explorable, ours.makespan_s
    given_up_m2 = math.fsum(ours.given_up_m2.values())
    figures = [
        _figure("explorable", ours.explorable_area_m2, whole, AREA, of=whole),
        _figure("seen", ours.seen_area_m2, judged.seen, AREA, of=whole),
        _figure("covered", ours.covered_area_m2, judged.covered, AREA, of=whole),
        _figure("seen, share", ours.seen, judged.seen / whole, AREA),
        _figure("coverage", ours.coverage, judged.covered / whole, AREA),
        _figure("given up, together", given_up_m2, whole - judged.covered, 2.0 * AREA, of=whole),
        _figure("overlap", ours.overlap_area_m2, judged.overlap, AREA, of=whole),
        _figure("lost", ours.lost_area_m2, judged.lost, AREA, of=whole),
        _figure("known to one", ours.known_to_one_m2, judged.known_to_one, AREA, of=whole),
        _figure(
            "known to one, integral",
            ours.known_to_one_m2s,
            judged.known_to_one_m2s,
            AREA,
            of=whole * end_s,
        ),
        _figure(
            "coverage, integral",
            ours.coverage_integral_s,
            judged.integral_of_rest(end_s),
            AREA,
            of=end_s,
        ),
    ]
    for name, share, time_s in (
        ("time to 90 %", 0.90, ours.time_to_90_s),
        ("time to 95 %", 0.95, ours.time_to_95_s),
        ("time to 99 %", 0.99, ours.time_to_99_s),
    ):
        # Where the curve stays near the share, either side of it is right.
        first_s, last_s = judged.covered_s(share - AREA), judged.covered_s(share + AREA)
        figures.append(_time(name, time_s, judged.covered_s(share), (first_s, last_s)))
    first_s, last_s = (judged.complete_s(KNOWN + sign * 2.0 * AREA) for sign in (-1.0, 1.0))
    complete_s = judged.complete_s(KNOWN)
    figures.append(_time("known complete", ours.known_complete_s, complete_s, (first_s, last_s)))
    return figures


def _curve(recording: Recording, world: Environment, judged: Areas) -> Figure:
    # The largest difference of the area covered, after any scan and any node.
    what = explorable(world, viewers(recording.spec, recording.starts))
    ours = coverage(evidence(recording, world, what))
    times, backwards = np.unique(judged.times[::-1], return_index=True)
    theirs = judged.curve[::-1][backwards]
    differences = [
        ours.covered_by_m2(time_s) - area_m2
        for time_s, area_m2 in zip(times.tolist(), theirs.tolist(), strict=True)
    ]
    worst = int(np.argmax(np.abs(differences)))
    area_m2 = float(theirs[worst])
    return _figure(
        "covered, at any time",
        area_m2 + differences[worst],
        area_m2,
        AREA,
        of=judged.explorable,
    )


def _motions(ours: Metrics, recording: Recording, world: Environment) -> list[Figure]:
    driven_tracks = tracks(recording)
    driven = [float(track.lengths.sum()) for track in driven_tracks]
    total_m = math.fsum(driven)
    figures = [
        _figure("distance", ours.total_distance_m, total_m, LENGTH, of=total_m),
        *(
            _figure("distance of a robot", one, other, LENGTH, of=other)
            for one, other in zip(ours.distance_by_robot_m, driven, strict=True)
        ),
        _figure("spread of the distance", ours.distance_spread_m, float(np.std(driven)), 1e-4),
        _figure(
            "clearance",
            ours.min_clearance_m,
            clearance_m(recording, driven_tracks, world.free),
            GAP_M,
        ),
    ]
    between_m = between_robots_m(recording, driven_tracks)
    if between_m is not None and ours.min_distance_between_robots_m is not None:
        figures.append(
            _figure("between robots", ours.min_distance_between_robots_m, between_m, GAP_M)
        )
        figures += _links(
            ours, links(recording, driven_tracks, world.free), recording, driven_tracks
        )
    return figures


def _links(
    ours: Metrics, judged: Links, recording: Recording, driven_tracks: list[Track]
) -> list[Figure]:
    # Each change is found to within a step, and what lasts for less than one may be missed.
    allowed_s = STEP_S * (2.0 + judged.changes)
    fastest = max(robot.drive.speed_m_s for robot in recording.spec.robots)
    figures = [
        _figure("isolated, any", ours.isolated_total_s, judged.total_s, allowed_s),
        _figure("isolated, longest", ours.isolated_longest_s, judged.longest_s, allowed_s),
        _figure("split", ours.split_s, judged.split_s, allowed_s),
        *(
            _figure("isolated, of a robot", one, other, allowed_s)
            for one, other in zip(ours.isolated_by_robot_s, judged.by_robot_s, strict=True)
        ),
    ]
    if judged.beyond_m is not None and ours.beyond_range_m is not None:
        allowed_m = 2.0 * fastest * STEP_S
        figures.append(_figure("beyond the range", ours.beyond_range_m, judged.beyond_m, allowed_m))
    return figures


def _figure(name: str, ours: float, judged: float, allowed: float, of: float = 1.0) -> Figure:
    # Differences are shares of what is measured, if that is given.
    difference = abs(ours - judged) / of if of else abs(ours - judged)
    return Figure(name=name, ours=ours, judged=judged, difference=difference, allowed=allowed)


def _time(name: str, ours: float | None, judged: float, span: tuple[float, float]) -> Figure:
    # A time that was never reached is infinite; within the span every time is right.
    time_s = math.inf if ours is None else ours
    before = 0.0 if time_s >= span[0] else span[0] - time_s
    after = 0.0 if time_s <= span[1] else time_s - span[1]
    return Figure(
        name=name, ours=time_s, judged=judged, difference=max(before, after), allowed=TIME_S
    )
