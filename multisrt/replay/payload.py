"""The data of a replay: all that its page shows, made of a recording and nothing else."""

from __future__ import annotations

import zlib
from base64 import b64encode
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import msgspec
import numpy as np
import shapely

from multisrt.analysis.activity import ACTIVITIES, activities
from multisrt.analysis.isolation import Isolation, isolation
from multisrt.analysis.run_tables import coverage_curve
from multisrt.drawing.account import outcome_told
from multisrt.environments.environment import Environment
from multisrt.events import NodeAdded, Sensed
from multisrt.explain.conditions import conditions, deaths
from multisrt.recording import Recording
from multisrt.replay.event_text import packed_explanations, packed_log
from multisrt.replay.labels import with_labels
from multisrt.replay.moving import packed_bridges, packed_goals, packed_robots
from multisrt.replay.nodes import (
    Names,
    packed_delivered,
    packed_learned,
    packed_nodes,
    packed_scans,
)
from multisrt.replay.packing import UNIT_M, UNIT_S, Packed, points, whole
from multisrt.replay.team import (
    packed_arcs,
    packed_groups,
    packed_links,
    packed_messages,
    packed_stops,
)

VERSION: Final = 1
"""Version of the data, which the page checks."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Detail:
    """How exactly a page shows a run: its size follows.

    Attributes
    ----------
    tolerance_m : float
        How far outlines of regions and scans may move, in metres.
    choices_only : bool
        Whether explanations are those of the times of decisions, not of what changes in between.
    explanations : bool
        Whether there are explanations.
    """

    tolerance_m: float
    choices_only: bool = False
    explanations: bool = True

    def notes(self) -> list[str]:
        """Return what a reader of the page must know about it, in words."""
        notes = []
        if self.tolerance_m > DETAILS[0].tolerance_m:
            notes.append(
                f"To keep the file small, outlines of regions are {self.tolerance_m * 100:g} cm "
                "off at most."
            )
        if not self.explanations:
            notes.append("To keep the file small, it has no explanations: use multisrt why.")
        elif self.choices_only:
            notes.append(
                "To keep the file small, explanations are those of the times of decisions."
            )
        return notes


DETAILS: Final = (
    Detail(tolerance_m=0.002),
    Detail(tolerance_m=0.02),
    Detail(tolerance_m=0.02, choices_only=True),
    Detail(tolerance_m=0.05, choices_only=True),
    Detail(tolerance_m=0.05, choices_only=True, explanations=False),
)
"""Details of pages, from the finest; a page has the first that makes its file small enough."""


def payload(recordings: Sequence[Recording], detail: Detail = DETAILS[0]) -> Packed:
    """Return the data of a page.

    Parameters
    ----------
    recordings : sequence of Recording
        The runs that are shown side by side; of a run that goes on, its recording so far.
    detail : Detail, optional
        How exactly it shows them.

    Returns
    -------
    dict
        Plain data for JSON: equal recordings give equal data.
    """
    return next(payloads(recordings, (detail,)))


def payloads(
    recordings: Sequence[Recording], details: Sequence[Detail] = DETAILS
) -> Iterator[Packed]:
    """Yield the data of a page in several details; what they have in common is made once."""
    common = [_packed_run(recording) for recording in recordings]
    for detail in details:
        runs = [
            run | _packed_detail(recording, detail)
            for run, recording in zip(common, recordings, strict=True)
        ]
        yield assembled(runs, detail.notes())


def packed_run(recording: Recording, detail: Detail) -> Packed:
    """Return the data of one run."""
    return _packed_run(recording) | _packed_detail(recording, detail)


def assembled(runs: Sequence[Packed], notes: Sequence[str]) -> Packed:
    """Return the data of a page with packed runs, and notes for its reader."""
    return {"version": VERSION, "notes": list(notes), "runs": with_labels(runs)}


def compressed(data: Packed) -> str:
    """Return the data of a page as text: JSON, deflated (RFC 1951), in base 64.

    Examples
    --------
    >>> compressed({"version": 1})
    'q1YqSy0qzszPU7IyrAUA'
    """
    packer = zlib.compressobj(9, zlib.DEFLATED, -zlib.MAX_WBITS)
    text = msgspec.json.encode(data)
    return b64encode(packer.compress(text) + packer.flush()).decode()


def _packed_detail(recording: Recording, detail: Detail) -> Packed:
    names, explanations = Names.of(recording), None
    if detail.explanations:
        explanations = packed_explanations(recording, choices_only=detail.choices_only)
    return {
        "nodes": packed_nodes(recording, names, detail.tolerance_m),
        "scans": packed_scans(recording, names, detail.tolerance_m),
        "explanations": explanations,
    }


def _packed_run(recording: Recording) -> Packed:
    environment = recording.environment()
    names = Names.of(recording)
    cut_off = isolation(recording, environment)
    spec, footer = recording.spec, recording.footer
    is_judged = bool(recording.of(Sensed)) or not recording.of(NodeAdded)
    return {
        "title": f"{spec.strategy} in {recording.header.world}, seed {spec.seed}",
        "outcome": outcome_told(recording),
        "reason": footer.reason,
        "conditions": conditions(spec),
        "deaths": deaths(recording),
        "digest": footer.digest,
        "made": recording.header.versions.get("multisrt", ""),
        "end": round(footer.time_s / UNIT_S),
        "world": _packed_world(environment),
        "base": None if spec.base is None else [round(c / UNIT_M) for c in spec.base.place],
        "robots": packed_robots(recording),
        "learned": packed_learned(recording, names),
        "delivered": packed_delivered(recording, names),
        "goals": packed_goals(recording),
        "bridges": packed_bridges(recording, names),
        "messages": packed_messages(recording),
        "links": packed_links(recording, environment),
        "groups": packed_groups(recording),
        "stops": packed_stops(recording),
        "arcs": packed_arcs(recording),
        "log": packed_log(recording),
        "activities": _packed_activities(recording, environment, cut_off),
        "curves": {
            "coverage": _packed_coverage(recording, environment) if is_judged else None,
            "isolated": _packed_isolation(cut_off),
        },
    }


def _packed_world(environment: Environment) -> Packed:
    parts = list(environment.free.geoms)
    rings = [
        [shapely.get_coordinates(ring)[:-1] for ring in (part.exterior, *part.interiors)]
        for part in parts
    ]
    return {
        "bounds": [round(value / UNIT_M) for value in environment.free.bounds],
        "rings": points([ring for part in rings for ring in part]),
    }


def _packed_activities(
    recording: Recording, environment: Environment, cut_off: Sequence[Isolation]
) -> Packed:
    spells = activities(recording, environment, with_isolation=False)
    names: list[str] = [name for name in ACTIVITIES if name != "cut off"]
    return {
        "names": names,
        "robots": [
            {
                "t": whole([spell.start_s for spell in own], UNIT_S),
                "what": [names.index(spell.activity) for spell in own],
            }
            for own in spells
        ],
        "cut_off": [
            {
                "begin": whole([begin for begin, _ in own.spells], UNIT_S),
                "end": whole([end for _, end in own.spells], UNIT_S),
            }
            for own in cut_off
        ],
    }


def _packed_coverage(recording: Recording, environment: Environment) -> Packed:
    columns = coverage_curve(recording, environment)
    shares = {
        name: columns[name].values for name in ("coverage", "seen", "delivered") if name in columns
    }
    return {"t": whole(columns["time_s"].values, UNIT_S)} | {
        # In hundredths of a percent.
        name: whole(values, 1e-4)
        for name, values in shares.items()
    }


def _packed_isolation(cut_off: Sequence[Isolation]) -> Packed:
    # How many robots are cut off from all others, at each time at which that changes.
    changes = [
        change
        for robot in cut_off
        for begin, end in robot.spells
        for change in ((begin, 1), (end, -1))
    ]
    changes.sort()
    return {
        "t": whole([time for time, _ in changes], UNIT_S),
        "robots": np.cumsum([change for _, change in changes], dtype=np.int64).tolist(),
    }
