"""When pairs of robots had a radio link."""

from __future__ import annotations

import itertools
import math
from collections import defaultdict

from multisrt.analysis.isolation import presence
from multisrt.analysis.isolation_spells import RESOLUTION_S, Spell
from multisrt.analysis.link_changes import link_changes
from multisrt.analysis.moving_points import standing_track, track_of_legs
from multisrt.analysis.poses import tracks
from multisrt.environments.environment import Environment
from multisrt.recording import Recording


def radio_links(
    recording: Recording, environment: Environment | None = None
) -> dict[tuple[int, int], tuple[Spell, ...]]:
    """Return when each pair of robots had a radio link.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment, optional
        The world, if it has been built already; by default it is built from the recording where
        walls matter to the radio.

    Returns
    -------
    dict of (int, int) to tuple of (begin_s, end_s)
        By pairs of robots, the lower number first; pairs without any link are left out. The base
        station takes part from begin to end, under the number after that of the last robot. Links
        are those of the run's `RadioSpec`, without delays and losses, between robots that take
        part and whose radios work; see `multisrt.analysis.isolation.team_isolation`.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, RobotSpec, RunSpec, simulate
    >>> world = CatalogEnvironment(name="open")
    >>> spec = RunSpec(environment=world, robots=(RobotSpec(), RobotSpec()), strategy="minpos")
    >>> recording = simulate(spec)
    >>> radio_links(recording) == {(0, 1): ((0.0, recording.footer.time_s),)}
    True
    """
    spec, end = recording.spec.radio, recording.footer.time_s
    present, switches = presence(recording)
    base = recording.spec.base
    if base is not None:
        present.append((0.0, end))
    pairs = list(itertools.combinations(range(len(present)), 2))
    near: dict[tuple[int, int], list[float]] = defaultdict(list)
    if spec.reaches_everywhere:
        near.update({pair: [0.0] for pair in pairs})
    elif pairs:
        ways = [track_of_legs(track.legs) for track in tracks(recording)]
        if base is not None:
            ways.append(standing_track(base.place, end))
        if spec.walls_matter and environment is None:
            environment = recording.environment()
        for time, _, i, j in link_changes(spec, ways, environment):
            near[i, j].append(time)
    works = [_working(present[robot], switches, robot) for robot in range(len(present))]
    found = {}
    for pair in pairs:
        spells = _spells(near[pair], end)
        for robot in pair:
            spells = _common(spells, works[robot])
        if spells := [(a, b) for a, b in spells if b - a > RESOLUTION_S]:
            found[pair] = tuple(spells)
    return found


def _working(present: Spell, switches: list[tuple[float, int]], robot: int) -> list[Spell]:
    # When it takes part and its radio works.
    off = sorted(time for time, other in switches if other == robot)
    return _common([present], _spells([-math.inf, *off], math.inf))


def _spells(changes: list[float], end: float) -> list[Spell]:
    # A state that changes at some times, from one in which it does not hold.
    changes = [*sorted(changes), end] if len(changes) % 2 else sorted(changes)
    return list(zip(changes[::2], changes[1::2], strict=True))


def _common(some: list[Spell], others: list[Spell]) -> list[Spell]:
    met = [(max(a, c), min(b, d)) for a, b in some for c, d in others]
    return [(begin, until) for begin, until in met if begin < until]
