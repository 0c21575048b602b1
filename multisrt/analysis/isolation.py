"""Isolation: the times at which robots were cut off from their team, and their distances.

The intervals are computed exactly from trajectories and events, not by sampling; see
`multisrt.analysis.link_changes`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

from multisrt.analysis.isolation_spells import (
    NEAR,
    PRESENT,
    SILENT,
    Change,
    Spell,
    spells_of_isolation,
)
from multisrt.analysis.link_changes import link_changes
from multisrt.analysis.moving_points import standing_track, track_of_legs
from multisrt.analysis.poses import tracks as tracks_of
from multisrt.analysis.separation import largest_separation
from multisrt.environments.environment import Environment
from multisrt.events import CameBack, Died, FellSilent, Joined
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.recording import Recording
from multisrt.spec import LateStart

__all__ = ["Isolation", "Spell", "TeamIsolation", "isolation", "team_isolation"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Isolation:
    """Times at which a robot was cut off from all others.

    Attributes
    ----------
    total_s : float
        Total time.
    longest_s : float
        Duration of the longest spell.
    beyond_range_m : float or None
        The largest distance to the nearest other active robot, minus the range of the radio, while
        the robot was isolated. 0 if it was never isolated, or only by silence or walls and not by
        distance; None for a radio of unlimited range.
    spells : tuple of (begin_s, end_s)
        The intervals in which it was isolated, in order.
    """

    total_s: float
    longest_s: float
    beyond_range_m: float | None
    spells: tuple[Spell, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class TeamIsolation:
    """Times at which the robots of a team were cut off from each other.

    Attributes
    ----------
    robots : tuple of Isolation
        One for each robot.
    total_s : float
        Time during which at least one robot was isolated.
    longest_s : float
        Duration of the longest spell of one robot.
    beyond_range_m : float or None
        The largest of the robots' values.
    split_s : float
        Time during which some robot could not have reached another one: with relays, while the
        network had more than one part; without relays, while the link between any two robots was
        missing.
    """

    robots: tuple[Isolation, ...]
    total_s: float
    longest_s: float
    beyond_range_m: float | None
    split_s: float


def isolation(
    recording: Recording, environment: Environment | None = None
) -> tuple[Isolation, ...]:
    """Measure the isolation of each robot from all others.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment, optional
        The world, if it has been built already; by default it is built from the recording where
        walls matter to the radio.

    Returns
    -------
    tuple of Isolation
        One for each robot. Isolation is defined at `team_isolation`.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, RadioSpec, RobotSpec, RunSpec, isolation, simulate
    >>> spec = RunSpec(
    ...     environment=CatalogEnvironment(name="apartment"),
    ...     robots=(RobotSpec(), RobotSpec()),
    ...     radio=RadioSpec(range_m=0.0),
    ...     strategy="minpos",
    ... )
    >>> recording = simulate(spec)
    >>> first, second = isolation(recording)
    >>> first.spells == ((0.0, recording.footer.time_s),)
    True
    """
    return team_isolation(recording, environment).robots


def team_isolation(recording: Recording, environment: Environment | None = None) -> TeamIsolation:
    """Measure the isolation of the robots of a team from each other.

    A robot is isolated while other robots are active and it has no link to any of them. Relays make
    no difference, because a robot that is reached through a relay has a link to that relay; only a
    base station that relays counts as a link between the robots that have a link to it. Links are
    those of the run's `RadioSpec`, without delays and losses; a robot whose radio is silent has
    none. A robot is active from the time when it is switched on until its death or the end of the
    run, also after it is done; if only one robot is active, it is not isolated.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment, optional
        The world, if it has been built already; by default it is built from the recording where
        walls matter to the radio. Robots are taken to have kept out of its walls.

    Returns
    -------
    TeamIsolation
        Times are exact to a microsecond, distances to a micrometre. If a robot on an arc stays
        within a micrometre of the place where a link begins, times are those for a range that
        differs by as much.

    Notes
    -----
    Source: J. C. Elizondo, G. Ramírez, E. Rodriguez and J. R. Martínez, Multi-robot Exploration
    Using Self-Biddings under Constraints on Communication Range (SBX-R), section IV and Tables I
    to III: `total_s`, `longest_s` and `beyond_range_m` of the team; differs in: the paper calls
    the first also the time in which the network was broken, but two halves of a team that are out
    of range of each other break it without isolating any robot, which `split_s` measures.
    """
    spec, end = recording.spec.radio, recording.footer.time_s
    present, silent = presence(recording)
    alone = len(present) < 2
    reaches_all = spec.reaches_everywhere
    tracks: list[FloatArray] = []
    relays = [
        standing_track(base.place, end)
        for base in (recording.spec.base,)
        if base is not None and spec.multi_hop
    ]
    if not (alone or reaches_all):
        tracks = [track_of_legs(track.legs) for track in tracks_of(recording)]
        if spec.walls_matter and environment is None:
            environment = recording.environment()
    changes = [*_switches(present, silent)]
    if reaches_all:
        changes += [(0.0, NEAR, i, j) for i, j in itertools.combinations(range(len(present)), 2)]
    elif not alone:
        changes += link_changes(spec, [*tracks, *relays], environment)
    *spells, any_isolated, split = spells_of_isolation(
        changes, len(present), end, spec.multi_hop, relays=len(relays)
    )
    robots = []
    for robot, own in enumerate(spells):
        beyond = None if spec.range_m is None else 0.0
        if own and spec.range_m is not None:
            farthest = largest_separation(robot, own, tracks, present)
            beyond = max(0.0, farthest - spec.range_m)
        robots.append(
            Isolation(
                total_s=_duration(own),
                longest_s=max((b - a for a, b in own), default=0.0),
                beyond_range_m=beyond,
                spells=own,
            )
        )
    return TeamIsolation(
        robots=tuple(robots),
        total_s=_duration(any_isolated),
        longest_s=max(robot.longest_s for robot in robots),
        beyond_range_m=max(
            (robot.beyond_range_m for robot in robots if robot.beyond_range_m is not None),
            default=None,
        ),
        split_s=_duration(split),
    )


def _duration(spells: tuple[Spell, ...]) -> float:
    return math.fsum(end - begin for begin, end in spells)


def presence(recording: Recording) -> tuple[list[Spell], list[tuple[float, int]]]:
    """Return when each robot takes part, and when which radio falls silent or comes back."""
    end = recording.footer.time_s
    late = {fault.robot for fault in recording.spec.faults if isinstance(fault, LateStart)}
    robots = range(len(recording.starts))
    begins = [math.inf if robot in late else 0.0 for robot in robots]
    ends = [end for _ in robots]
    for joined in recording.of(Joined):
        begins[joined.robot] = joined.time_s
    for died in recording.of(Died):
        ends[died.robot] = min(end, died.time_s)
    changes = (*recording.of(FellSilent), *recording.of(CameBack))
    silent = [(change.time_s, change.robot) for change in changes]
    return list(zip(begins, ends, strict=True)), silent


def _switches(present: list[Spell], silent: list[tuple[float, int]]) -> Iterator[Change]:
    for robot, (begin, end) in enumerate(present):
        if begin < end:
            yield begin, PRESENT, robot, robot
            yield end, PRESENT, robot, robot
    for time, robot in silent:
        yield time, SILENT, robot, robot
