"""A run as tables: where robots were, what the team covered when, and all that happened."""

from __future__ import annotations

import msgspec
import numpy as np

from multisrt.analysis.coverage import coverage
from multisrt.analysis.delivery import delivery
from multisrt.analysis.evidence import evidence
from multisrt.analysis.explorable import explorable, viewers
from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent, Motion
from multisrt.extras.frames import Column
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.recording import Recording

Columns = dict[str, Column]

_ENCODER = msgspec.json.Encoder()


def trajectories(recording: Recording) -> Columns:
    """Return the waypoints of all robots.

    Parameters
    ----------
    recording : Recording
        The run.

    Returns
    -------
    dict of str to Column
        `robot`, `time_s`, `x_m`, `y_m`, `heading_rad`, and the `motion` that the waypoint belongs
        to, counted from 0 for each robot, with its `purpose`. The first row of a robot is its
        start, of no motion. Rows are sorted by robot and time. Between two waypoints of a motion
        the body moves with a constant twist, see `multisrt.events.Motion`; between two motions it
        stands.

    Examples
    --------
    >>> import multisrt as ms
    >>> columns = trajectories(ms.explore("open", seed=1, max_time_s=10.0).recording)
    >>> [values[0] for _, values in columns.values()][-2:], columns["motion"].values[1]
    ([None, None], 0)
    """
    motions: list[list[Motion]] = [[] for _ in recording.starts]
    for event in recording.of(Motion):
        motions[event.robot].append(event)
    rows: list[tuple[object, ...]] = []
    for robot, start in enumerate(recording.starts):
        rows.append((robot, 0.0, *start, None, None))
        for number, motion in enumerate(motions[robot]):
            rows += [(robot, *waypoint, number, motion.purpose) for waypoint in motion.waypoints]
    kinds = {
        "robot": int,
        "time_s": float,
        "x_m": float,
        "y_m": float,
        "heading_rad": float,
        "motion": int,
        "purpose": str,
    }
    values = zip(*rows, strict=True)
    return {
        name: Column(kind, own) for (name, kind), own in zip(kinds.items(), values, strict=True)
    }


def coverage_curve(recording: Recording, environment: Environment) -> Columns:
    """Return how much the team had covered and seen at every time at which that changed.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment
        Its world.

    Returns
    -------
    dict of str to Column
        `time_s`; `coverage` and `seen`, the shares of the explorable area from 0 to 1;
        `covered_area_m2` and `seen_area_m2`. They mean what they mean in `Metrics`, and hold from
        that time until the next row. The first row is at time 0, the last at the end of the run.
        With a base station also `delivered`, the share that it knows, and `delivered_area_m2`.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", seed=1)
    >>> columns = coverage_curve(run.recording, run.environment)
    >>> float(columns["coverage"].values[-1]) == run.metrics.coverage
    True
    """
    what = explorable(environment, viewers(recording.spec, recording.starts))
    proof = evidence(recording, environment, what)
    curve = coverage(proof)
    curves = {
        "coverage": ("covered_area_m2", curve.times_s, curve.covered_m2),
        "seen": ("seen_area_m2", curve.times_s, curve.seen_m2),
    }
    if (known := delivery(proof, curve)) is not None:
        curves["delivered"] = "delivered_area_m2", known.times_s, known.delivered_m2
    changes_s = [own_s for _, own_s, _ in curves.values()]
    times_s = np.unique(np.concatenate([[0.0], *changes_s, [recording.footer.time_s]]))
    areas = {
        name: (area, _at(times_s, own_s, own_m2)) for name, (area, own_s, own_m2) in curves.items()
    }
    return {
        "time_s": Column(float, times_s),
        **{
            name: Column(float, np.minimum(1.0, area_m2 / curve.explorable_m2))
            for name, (_, area_m2) in areas.items()
        },
        **{area: Column(float, area_m2) for area, area_m2 in areas.values()},
    }


def _at(times_s: FloatArray, changes_s: FloatArray, areas_m2: FloatArray) -> FloatArray:
    # Areas at some times, from those that hold after each change; 0 before the first.
    last = np.searchsorted(changes_s, times_s, side="right")
    areas: FloatArray = np.concatenate([[0.0], areas_m2])[last]
    return areas


def events(recording: Recording) -> Columns:
    """Return the events of a run, in the order of its recording.

    Parameters
    ----------
    recording : Recording
        The run.

    Returns
    -------
    dict of str to Column
        `time_s`, `robot`, the kind of `event` as in the file of a recording; `x_m`, `y_m` and
        `heading_rad` of an event with a configuration; and `fields`, all that the event says
        besides, as JSON.

    Examples
    --------
    >>> import multisrt as ms
    >>> columns = events(ms.explore("open", seed=1, max_time_s=10.0).recording)
    >>> columns["event"].values[0], columns["fields"].values[0]
    ('sensed', '{}')
    """
    rows = [_row(event) for event in recording.events]
    kinds = {
        "time_s": float,
        "robot": int,
        "event": str,
        "x_m": float,
        "y_m": float,
        "heading_rad": float,
        "fields": str,
    }
    return _columns(kinds, rows)


def _columns(kinds: dict[str, type], rows: list[tuple[object, ...]]) -> Columns:
    return {
        name: Column(kind, [row[number] for row in rows])
        for number, (name, kind) in enumerate(kinds.items())
    }


def _row(event: AnyEvent) -> tuple[object, ...]:
    every = msgspec.structs.asdict(event)
    fields = {name: value for name, value in every.items() if value is not msgspec.UNSET}
    time_s, robot = fields.pop("time_s"), fields.pop("robot")
    place = fields.pop("configuration", (None, None, None))
    kind = type(event).__struct_config__.tag
    return time_s, robot, kind, *place, _ENCODER.encode(fields).decode()
