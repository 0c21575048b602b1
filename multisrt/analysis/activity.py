"""What robots were doing at any time of a run, from its events."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Final, Literal, NamedTuple, get_args

import numpy as np

from multisrt.analysis.isolation import isolation
from multisrt.analysis.poses import Track, tracks
from multisrt.environments.environment import Environment
from multisrt.events import Coordinated, Died, Ended, Joined, Organized
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.recording import Recording
from multisrt.spec import LateStart

Activity = Literal[
    "waits", "coordinates", "moves", "supports", "cut off", "done", "dead", "not started"
]
"""What a robot is doing; see `activities`. Where several apply, the last of them counts."""

ACTIVITIES: Final[tuple[Activity, ...]] = get_args(Activity)


class Spell(NamedTuple):
    """A span of time in which a robot was doing one thing.

    Attributes
    ----------
    start_s, end_s : float
        From when to when, in seconds since the start of the run.
    activity : str
        What it was doing; see `activities`.
    """

    start_s: float
    end_s: float
    activity: Activity


def activities(
    recording: Recording, environment: Environment | None = None, *, with_isolation: bool = True
) -> list[list[Spell]]:
    """Return what each robot was doing at any time of a run.

    A robot is, the first that applies:

    - ``not started``: it starts late and has not been switched on (`Joined`);
    - ``dead``: since it died (`Died`);
    - ``done``: since it ended (`Ended`), until it next sets out if it is called on;
    - ``cut off``: it is isolated, see `multisrt.isolation`; whether it moves or not;
    - ``supports``: it moves for the tree of another robot (a `Motion` for the purpose `support`);
    - ``moves``: it drives or turns, for any other purpose;
    - ``coordinates``: it stands between two motions, and a master organises its group meanwhile (it
      is the robot of a `Coordinated` or `Organized` event). The whole stand counts: the robot waits
      for the group to gather, for the order, and to be let go. Only robots of the SRT family do;
      those that bid for frontiers agree while they drive;
    - ``waits``: it stands otherwise.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment, optional
        The world, if it has been built already; by default it is built from the recording where
        walls matter to the radio.
    with_isolation : bool, optional
        Whether ``cut off`` is an activity, which hides what the robot does meanwhile. Without it,
        `multisrt.isolation` tells when robots were cut off.

    Returns
    -------
    list of list of Spell
        The spells of each robot, in order. They follow one another without gaps from 0 to the end
        of the run, each with another activity than the one before; a run of no duration has none.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
    >>> first, second = activities(run.recording)
    >>> first[0].start_s, first[-1].end_s == run.recording.footer.time_s
    (0.0, True)
    """
    end_s = recording.footer.time_s
    spans: list[list[Spell]] = [[] for _ in recording.starts]
    for robot, spell in _spans_of_events(recording):
        spans[robot].append(spell)
    ways = tracks(recording)
    for robot, own in enumerate(spans):
        own += _moving(ways[robot])
    if with_isolation:
        for own, cut_off in zip(spans, isolation(recording, environment), strict=True):
            own += [Spell(*spell, "cut off") for spell in cut_off.spells]
    _end(recording, ways, spans)
    _coordinate(recording, ways, spans)
    return [_partition(own, end_s) for own in spans]


def _spans_of_events(recording: Recording) -> Iterator[tuple[int, Spell]]:
    joined = {event.robot: event.time_s for event in recording.of(Joined)}
    for fault in recording.spec.faults:
        if isinstance(fault, LateStart):
            yield fault.robot, Spell(-math.inf, joined.get(fault.robot, math.inf), "not started")
    for event in recording.of(Died):
        yield event.robot, Spell(event.time_s, math.inf, "dead")


def _moving(track: Track) -> list[Spell]:
    spells = [Spell(begin, end, "moves") for begin, end in track.moving_spans().tolist()]
    supporting = track.moving_spans("support").tolist()
    return spells + [Spell(begin, end, "supports") for begin, end in supporting]


def _end(recording: Recording, ways: tuple[Track, ...], spans: list[list[Spell]]) -> None:
    for event in recording.of(Ended):
        begins = ways[event.robot].moving_spans()[:, 0]
        later = begins[begins >= event.time_s]
        until = float(later[0]) if len(later) else math.inf
        spans[event.robot].append(Spell(event.time_s, until, "done"))


def _coordinate(recording: Recording, ways: tuple[Track, ...], spans: list[list[Spell]]) -> None:
    for event in (*recording.of(Coordinated), *recording.of(Organized)):
        moving = ways[event.robot].moving_spans()
        before, after = moving[:, 1], moving[:, 0]
        since = float(np.max(before[before <= event.time_s], initial=0.0))
        until = float(np.min(after[after >= event.time_s], initial=math.inf))
        spans[event.robot].append(Spell(since, until, "coordinates"))


def _partition(spans: list[Spell], end_s: float) -> list[Spell]:
    # What comes later in ACTIVITIES hides what comes before.
    if end_s <= 0.0:
        return []
    borders: FloatArray = np.unique(
        np.clip([0.0, end_s, *itertools.chain(*(s[:2] for s in spans))], 0.0, end_s)
    )
    found = np.zeros(len(borders) - 1, np.int64)
    for span in spans:
        first, last = np.searchsorted(borders, np.clip(span[:2], 0.0, end_s))
        level = ACTIVITIES.index(span.activity)
        found[first:last] = np.maximum(found[first:last], level)
    starts = np.flatnonzero(np.diff(found, prepend=-1))
    ends = [*starts[1:], len(found)]
    return [
        Spell(float(borders[a]), float(borders[b]), ACTIVITIES[found[a]])
        for a, b in zip(starts, ends, strict=True)
    ]
