"""When robots were cut off from one another, by sampling the time of a run."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from shapely.geometry.base import BaseGeometry

from benchmarks.judge.views import FloatArray
from multisrt.campaign.tracks import Track
from multisrt.events import CameBack, Died, FellSilent, Joined
from multisrt.recording import Recording
from multisrt.spec import LateStart, RadioSpec

BoolArray = NDArray[np.bool_]

STEP_S: Final = 0.01
"""Time between two samples: a link that holds for less than this may be missed, and then joins the
spells of isolation before and after it."""

TOUCH_M: Final = 1e-9
"""A line that is in an obstacle for no more than this touches it, in metres."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Links:
    """Times at which robots were cut off.

    Attributes
    ----------
    by_robot_s : tuple of float
        How long each robot had no link although others took part.
    total_s : float
        How long any of them had none.
    longest_s : float
        The longest time that one had none without a break.
    split_s : float
        How long some robot could not have reached another one.
    beyond_m : float or None
        The largest distance of a robot without links to the nearest other one, less the range.
    changes : int
        How many times any of this changed: each is found to within a step.
    """

    by_robot_s: tuple[float, ...]
    total_s: float
    longest_s: float
    split_s: float
    beyond_m: float | None
    changes: int


def links(recording: Recording, tracks: list[Track], free: BaseGeometry) -> Links:
    """Measure how robots were cut off: the state in the middle of each step counts for it."""
    spec, robots = recording.spec.radio, len(tracks)
    steps = max(1, math.ceil(recording.footer.time_s / STEP_S))
    step_s = recording.footer.time_s / steps
    times: FloatArray = (np.arange(steps, dtype=np.float64) + 0.5) * step_s
    present, working = _present(recording, times), _working(recording, times)
    places = np.stack([track.at(times)[:, :2] for track in tracks])
    linked = np.zeros((robots, robots, steps), np.bool_)
    apart = np.full((robots, robots, steps), np.inf)
    shapely.prepare(free)
    for i, j in itertools.combinations(range(robots), 2):
        there = present[i] & present[j]
        gap = np.hypot(*(places[i] - places[j]).T)
        apart[i, j] = apart[j, i] = np.where(there, gap, np.inf)
        asked = there & working[i] & working[j]
        asked[asked] = _holds(spec, places[i][asked], places[j][asked], gap[asked], free)
        linked[i, j] = linked[j, i] = asked
    team = present.sum(axis=0)
    alone = present & (team > 1) & ~linked.any(axis=1)
    split = _split(spec, linked, present)
    beyond = None
    if spec.range_m is not None:
        nearest = apart.min(axis=1)
        beyond = max(0.0, float(np.max(nearest[alone], initial=0.0)) - spec.range_m)
    flags = np.vstack([alone, alone.any(axis=0), split]).astype(np.int8)
    return Links(
        by_robot_s=tuple((alone.sum(axis=1) * step_s).tolist()),
        total_s=float(alone.any(axis=0).sum() * step_s),
        longest_s=max(_longest(row) for row in alone) * step_s,
        split_s=float(split.sum() * step_s),
        beyond_m=beyond,
        changes=int(np.abs(np.diff(flags, axis=1)).sum()),
    )


def _present(recording: Recording, times: FloatArray) -> BoolArray:
    late = {fault.robot for fault in recording.spec.faults if isinstance(fault, LateStart)}
    begins = {joined.robot: joined.time_s for joined in recording.of(Joined)}
    ends = {died.robot: died.time_s for died in recording.of(Died)}
    rows = []
    for robot in range(len(recording.header.starts)):
        begin = begins.get(robot, math.inf if robot in late else 0.0)
        rows.append((times >= begin) & (times < ends.get(robot, math.inf)))
    return np.array(rows)


def _working(recording: Recording, times: FloatArray) -> BoolArray:
    working = np.ones((len(recording.header.starts), len(times)), np.bool_)
    for event in recording.events:
        if isinstance(event, FellSilent | CameBack):
            working[event.robot] ^= times >= event.time_s
    return working


def _holds(
    spec: RadioSpec, one: FloatArray, two: FloatArray, gap: FloatArray, free: BaseGeometry
) -> BoolArray:
    reach = np.full(len(gap), math.inf if spec.range_m is None else spec.range_m)
    holds: BoolArray = gap <= reach
    if spec.walls == "pass":
        return holds
    lines = np.asarray(shapely.linestrings(np.stack([one[holds], two[holds]], axis=1)))
    walls = np.zeros(len(lines), np.int64)
    through = ~shapely.covers(free, lines)
    hidden = shapely.get_parts(shapely.difference(lines[through], free), return_index=True)
    long = shapely.length(hidden[0]) > TOUCH_M
    walls[through] = np.bincount(hidden[1][long], minlength=int(through.sum()))
    if spec.walls == "block":
        holds[holds] = walls == 0
    else:
        # 10 n log10(distance / range) + the loss of all walls <= 0.
        loss_db = walls * spec.wall_loss_db
        reach = reach[holds] * 10.0 ** (-loss_db / (10.0 * spec.path_loss_exponent))
        holds[holds] = gap[holds] <= reach
    return holds


def _split(spec: RadioSpec, linked: BoolArray, present: BoolArray) -> BoolArray:
    # With relays: more than one part; without them: any link missing.
    packed = np.vstack([linked.reshape(-1, linked.shape[2]), present])
    patterns, which = np.unique(packed, axis=1, return_inverse=True)
    split = np.zeros(patterns.shape[1], np.bool_)
    robots = len(present)
    for k in range(patterns.shape[1]):
        here = np.flatnonzero(patterns[-robots:, k])
        graph = patterns[:-robots, k].reshape(robots, robots)[np.ix_(here, here)]
        if len(here) < 2:
            continue
        if spec.multi_hop:
            split[k] = connected_components(graph, directed=False)[0] > 1
        else:
            split[k] = graph.sum() < len(here) * (len(here) - 1)
    return split[which.ravel()]


def _longest(row: BoolArray) -> int:
    return max((sum(1 for _ in run) for held, run in itertools.groupby(row) if held), default=0)
