"""Spells of isolation, from the moments at which robots, radios and links come and go."""

from __future__ import annotations

import numpy as np

from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray, kernel

RESOLUTION_S = 1e-6
"""Spells, and gaps between spells, that last no longer than this are dropped, in seconds."""

PRESENT, SILENT, NEAR = 0, 1, 2
"""What changes: whether a robot takes part, whether its radio is silent, or whether two robots
are near enough to each other for a link."""

Spell = tuple[float, float]
"""When something began and when it ended (s)."""

Change = tuple[float, int, int, int]
"""When (s), which of `PRESENT`, `SILENT`, `NEAR`, and of which robots: one twice, or two."""


def spells_of_isolation(
    changes: list[Change], robots: int, end_s: float, multi_hop: bool, *, relays: int = 0
) -> list[tuple[Spell, ...]]:
    """Return when each robot was isolated, when any robot was, and when the team was split.

    Parameters
    ----------
    changes : list of Change
        What changes, from a state in which nothing holds; it is sorted in place.
    robots : int
        The size of the team.
    end_s : float
        The end of the run.
    multi_hop : bool
        Whether robots relay messages, so that a connected network is not split.
    relays : int, optional
        How many relays there are that are no robots and always work; they have the numbers after
        the last robot.

    Returns
    -------
    list of tuple of Spell
        `robots` + 2 of them.
    """
    changes.sort()
    times = np.array([change[0] for change in changes])
    what = np.array([change[1:] for change in changes], np.int64).reshape(-1, 3)
    rows = _sweep(times, what, robots, relays, end_s, multi_hop)
    found: list[list[Spell]] = [[] for _ in range(robots + 2)]
    for number, begin, until in rows.tolist():
        spells = found[int(number)]
        if spells and begin - spells[-1][1] <= RESOLUTION_S:
            spells[-1] = spells[-1][0], until
        else:
            spells.append((begin, until))
    return [tuple((a, b) for a, b in spells if b - a > RESOLUTION_S) for spells in found]


@kernel
def _sweep(
    times: FloatArray, what: IntArray, robots: int, relays: int, end: float, multi_hop: bool
) -> FloatArray:
    # Spells (number, begin, end) of every robot, then of any of them and of a split team.
    state = np.zeros((3, robots + relays, robots + relays), np.bool_)
    since = np.full(robots + 2, -1.0)
    rows = [(0, 0.0, 0.0)]
    k = 0
    while k < times.shape[0] and times[k] < end:
        now = times[k]
        while k < times.shape[0] and times[k] == now:
            kind, i, j = what[k, 0], what[k, 1], what[k, 2]
            state[kind, i, j] = not state[kind, i, j]
            state[kind, j, i] = state[kind, i, j]
            k += 1
        cut_off = _cut_off(state, robots, multi_hop)
        for number in range(robots + 2):
            if cut_off[number] and since[number] < 0.0:
                since[number] = now
            elif not cut_off[number] and since[number] >= 0.0:
                rows.append((number, since[number], now))
                since[number] = -1.0
    for number in range(robots + 2):
        if since[number] >= 0.0:
            rows.append((number, since[number], end))
    spells = np.empty((len(rows) - 1, 3))
    for k in range(1, len(rows)):
        spells[k - 1, 0], spells[k - 1, 1], spells[k - 1, 2] = rows[k]
    return spells


@kernel
def _cut_off(state: BoolArray, robots: int, multi_hop: bool) -> BoolArray:
    cut_off = np.zeros(robots + 2, np.bool_)
    team = 0
    first = -1
    for i in range(robots):
        if state[PRESENT, i, i]:
            team += 1
            first = i if first < 0 else first
    if team < 2:
        return cut_off
    links = np.zeros((robots, robots), np.bool_)
    for i in range(robots):
        if not state[PRESENT, i, i]:
            continue
        count = 0
        for j in range(robots):
            works = state[PRESENT, j, j] and not state[SILENT, i, i] and not state[SILENT, j, j]
            near = state[NEAR, i, j]
            for relay in range(robots, state.shape[1]):
                near |= state[NEAR, i, relay] and state[NEAR, j, relay]
            links[i, j] = j != i and works and near
            count += links[i, j]
        cut_off[i] = count == 0
        cut_off[robots] |= count == 0
        cut_off[robots + 1] |= count < team - 1
    if multi_hop and not cut_off[robots] and cut_off[robots + 1]:
        # The team is not split if all are reached from the first robot through others.
        reached = np.zeros(robots, np.bool_)
        reached[first] = True
        relays = [first]
        found = 1
        while len(relays):
            i = relays.pop()
            for j in range(robots):
                if links[i, j] and not reached[j]:
                    reached[j] = True
                    relays.append(j)
                    found += 1
        cut_off[robots + 1] = found < team
    return cut_off
