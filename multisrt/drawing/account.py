"""The texts around a picture of a run: heading, legend, and colours of robots."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from multisrt.analysis.run_tables import coverage_curve
from multisrt.drawing.colours import (
    CLOSED,
    COLLISION,
    CUT_OFF,
    DEATH,
    DEATH_MM,
    END,
    END_MM,
    FREE,
    FRONTIER,
    FRONTIER_CELLS,
    GOAL_MM,
    KNOWN,
    LATE_START,
    NODE_MM,
    STAGE_MARKERS,
    START,
    START_MM,
    STOP,
    STOP_MM,
    RobotStyles,
    Style,
)
from multisrt.drawing.sheet import LegendEntry, Swatch
from multisrt.drawing.svg import Marker
from multisrt.drawing.traces import Trace
from multisrt.events import (
    BaseLearned,
    CameBack,
    Collision,
    Died,
    Ended,
    FellSilent,
    Joined,
    NodeAdded,
)
from multisrt.explain.terms import stage_name
from multisrt.geometry.errors import counted
from multisrt.planners.home_options import NO_TIME_LEFT
from multisrt.recording import Recording

MAX_ACCOUNTS: Final = 16
"""Upper bound of the team size up to which the legend has figures of each robot."""

IN_COLOURS_OF_ROBOTS: Final = frozenset(
    {
        *("areas", "outlines", "paths", "support", "bridges", "edges", "nodes", "goals"),
        *("starts", "ends"),
    }
)
"""Layers that are drawn in the colours of the robots."""

OUTCOMES: Final = {"complete": "complete", "stalled": "stalled", "out_of_time": "out of time"}

HOME_IN_TIME: Final = "home in time"
"""How a run is said to have ended that stalled as its robots had no time left but to go home."""


def outcome_told(recording: Recording) -> str:
    """Return how a run ended, in words.

    Parameters
    ----------
    recording : Recording
        The run.

    Returns
    -------
    str
        The recorded outcome; of one that stalled, "home in time" if every robot that lives ended
        completely or for lack of time, and the base station has every node that these made.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore(
    ...     "open",
    ...     starts=[(1.0, 1.0)],
    ...     base=(1.0, 1.0),
    ...     radio_range_m=6.0,
    ...     strategy="minpos",
    ...     options={"home": "in-time"},
    ...     max_time_s=60.0,
    ... )
    >>> run.outcome, outcome_told(run.recording)
    ('stalled', 'home in time')
    """
    footer = recording.footer
    return HOME_IN_TIME if _are_home_in_time(recording) else OUTCOMES[footer.outcome]


def _are_home_in_time(recording: Recording) -> bool:
    if recording.footer.outcome != "stalled" or recording.of(Collision):
        return False
    dead = {event.robot for event in recording.of(Died)}
    ends = {event.robot: event for event in recording.of(Ended) if event.robot not in dead}
    late = [end.reason.startswith(NO_TIME_LEFT) for end in ends.values() if not end.complete]
    if len(ends) + len(dead) < len(recording.starts) or not late or not all(late):
        return False
    made = {(node.robot, node.serial) for node in recording.of(NodeAdded) if node.robot in ends}
    return made <= {tuple(name) for event in recording.of(BaseLearned) for name in event.nodes}


def run_title(recording: Recording) -> str:
    """Return the title of a picture: the strategy, the world, the team and the seed of the run."""
    spec = recording.spec
    team = f", {len(spec.robots)} robots" if len(spec.robots) > 1 else ""
    return f"{spec.strategy} in {recording.header.world}{team}, seed {spec.seed}"


def heading(recording: Recording, traces: list[Trace], status: str | None = None) -> list[str]:
    """Return the title of a picture and the lines below it: the run, its outcome and its faults.

    A status is reported instead of the outcome.
    """
    spec, footer = recording.spec, recording.footer
    nodes = sum(len(trace.nodes) for trace in traces)
    distance = math.fsum(trace.distance_m for trace in traces)
    outcome_is_told = status is None
    if status is None:
        status = f"{outcome_told(recording)} after {footer.time_s:,.0f} s"
    lines = [
        run_title(recording),
        f"{status}: {counted(nodes, _unit(traces, in_full=True))}, {distance:,.0f} m travelled",
    ]
    left = math.fsum(math.hypot(x1 - x0, y1 - y0) for t in traces for x0, y0, x1, y1 in t.frontier)
    if left:
        lines[-1] += f", {left:,.1f} m of open frontier left"
    if outcome_is_told and spec.base is not None:
        lines.append(_at_base(recording))
    if footer.outcome == "stalled":
        lines.append(footer.reason)
    if faults := _faults(recording):
        lines.append(faults)
    if spec.options:
        lines.append("with " + ", ".join(f"{k} = {v}" for k, v in spec.options.items()))
    return lines


def _at_base(recording: Recording) -> str:
    curve = coverage_curve(recording, recording.environment())
    covered, delivered = (100.0 * curve[name].values[-1] for name in ("coverage", "delivered"))
    return f"{covered:.1f} % covered, {delivered:.1f} % delivered to the base station"


def description(recording: Recording) -> str:
    """Return the source of a picture: the version of the program and the digest of the run."""
    return (
        f"A run of multisrt {recording.header.versions.get('multisrt', '')}, "
        f"digest {recording.footer.digest}."
    )


def legend(
    traces: list[Trace], absent: frozenset[str] = frozenset(), *, merged: bool = False
) -> list[LegendEntry]:
    """Return the legend of the trees, with entries for what is on the map only.

    Parameters
    ----------
    traces : list of Trace
        The robots.
    absent : frozenset of str
        Layers that are left out; see `multisrt.drawing.layers`.
    merged : bool
        Whether the regions of each robot are outlined as one.

    Returns
    -------
    list of LegendEntry
        The entries, in the order in which they are drawn.
    """
    team = len(traces) > 1
    styles = RobotStyles.of_any() if team else RobotStyles.of(0)
    stages = {node.stage for trace in traces for node in trace.nodes.values()}
    reasons = {event.reason for trace in traces for event in trace.closed}
    entries = _regions_legend(styles, absent, team, merged)
    if any(trace.edges for trace in traces) and "edges" not in absent:
        entries.append(LegendEntry(label="edge of the tree", style=styles.edge))
    for stage, marker in STAGE_MARKERS.items():
        if stage != "root" and stage in stages and "nodes" not in absent:
            entries.append(
                LegendEntry(
                    label=f"node: {stage_name(stage)}",
                    style=styles.node,
                    marker=marker,
                    size_mm=NODE_MM[1],
                )
            )
    for layer, label, style, there in (
        ("bridges", "bridge between two nodes", styles.bridge, any(t.bridges for t in traces)),
        ("support", "path in support of others", styles.support, any(t.supporting for t in traces)),
        (
            "paths",
            "path off the tree",
            styles.team_path if team else styles.path,
            any(t.off_tree for t in traces),
        ),
        ("frontier", "open frontier", FRONTIER, any(t.frontier for t in traces)),
        *(
            ("given-up", f"frontier given up: {why}", style, why in reasons)
            for why, style in CLOSED.items()
        ),
    ):
        if there and layer not in absent:
            entries.append(LegendEntry(label=label, style=style))
    return entries + marks_legend(traces, styles, absent)


def _regions_legend(
    styles: RobotStyles, absent: frozenset[str], team: bool, merged: bool
) -> list[LegendEntry]:
    if team:
        what = "the area that a robot saw" if merged else "a local safe region"
        # Thin and pale as on the map, it could not be seen.
        style = replace(styles.outline.scaled(3.0), stroke_opacity=0.8)
        return (
            [] if "outlines" in absent else [LegendEntry(label=f"outline of {what}", style=style)]
        )
    style = styles.region.scaled(2.0)
    if "outlines" in absent:
        style = replace(style, stroke=None)
    if "areas" in absent:
        style = replace(style, fill=None)
    there = style.fill or style.stroke
    return [LegendEntry(label="local safe region", style=style)] if there else []


def paths_legend(
    traces: list[Trace], absent: frozenset[str], there: frozenset[str]
) -> list[LegendEntry]:
    """Return the legend of frontier bidding, with entries for what is on the map only.

    Parameters
    ----------
    traces : list of Trace
        The robots.
    absent : frozenset of str
        Layers that are left out; see `multisrt.drawing.layers`.
    there : frozenset of str
        Which of the layers `goals`, `frontier` and `isolation` have something to show.

    Returns
    -------
    list of LegendEntry
        The entries, in the order in which they are drawn.
    """
    styles = RobotStyles.of_any() if len(traces) > 1 else RobotStyles.of(0)
    entries = []
    if len(traces) == 1 and "areas" not in absent:
        entries.append(LegendEntry(label="explored area", style=styles.area))
    elif "outlines" not in absent:
        entries.append(LegendEntry(label="border of the explored area", style=KNOWN))
    for layer, label, style, is_there in (
        ("paths", "path", styles.edge, any(t.motions for t in traces)),
        ("isolation", "path of an isolated robot", CUT_OFF, "isolation" in there),
        ("frontier", "frontier left on the map", FRONTIER_CELLS, "frontier" in there),
    ):
        if is_there and layer not in absent:
            entries.append(LegendEntry(label=label, style=style))
    if "goals" in there and "goals" not in absent:
        entries.append(
            LegendEntry(label="goal", style=styles.node, marker="diamond", size_mm=GOAL_MM)
        )
    return entries + marks_legend(traces, styles, absent)


def marks_legend(
    traces: list[Trace], styles: RobotStyles, absent: frozenset[str] = frozenset()
) -> list[LegendEntry]:
    """Return the legend of marks at single places: starts, ends, stops, deaths and collisions."""
    team = len(traces) > 1
    start: Marker = "pin" if team else "arrow"
    late = styles.late_start if team else LATE_START
    away = any(t.death is None and t.is_away for t in traces)
    marks: list[tuple[str, str, Style, Marker, float, bool]] = [
        (
            "starts",
            "start, with the robot's number" if team else "start",
            styles.start if team else START,
            start,
            START_MM,
            not all(t.late for t in traces),
        ),
        ("starts", "late start", late, start, START_MM, any(t.late for t in traces)),
        ("ends", "end", styles.end if team else END, "arrow", END_MM, away),
        ("stops", "protective stop", STOP, "octagon", STOP_MM, any(t.stops for t in traces)),
        ("failures", "death", DEATH, "cross", DEATH_MM, any(t.death for t in traces)),
        (
            "failures",
            "collision",
            COLLISION,
            "cross",
            START_MM,
            any(t.collisions for t in traces),
        ),
    ]
    return [
        LegendEntry(label=label, style=style, marker=marker, size_mm=size)
        for layer, label, style, marker, size, there in marks
        if there and layer not in absent
    ]


def swatches(traces: list[Trace], absent: frozenset[str] = frozenset()) -> list[Swatch]:
    """Return the colours of the robots, in a small team with nodes and path lengths.

    There are none if all layers in these colours are left out.
    """
    if absent >= IN_COLOURS_OF_ROBOTS:
        return []
    found = [_swatch(trace, len(traces), _unit(traces)) for trace in traces]
    return [replace(one, area=FREE) for one in found] if "areas" in absent else found


def swatches_heading(traces: list[Trace], absent: frozenset[str] = frozenset()) -> str:
    """Return the heading of the colours of the robots."""
    scans = _unit(traces) == "scan"
    unit = _unit(traces, in_full=True)
    account = f": {unit}s, path length" if len(traces) <= MAX_ACCOUNTS else ""
    lines = {"paths"} if scans else {"edges", "nodes"}
    parts = [
        *([] if "areas" in absent else ["area seen first"]),
        *([] if absent >= lines else ["path" if scans else "tree"]),
    ]
    return f"{' and '.join(parts) or 'colour'} of each robot{account}"


def _swatch(trace: Trace, robots: int, unit: str) -> Swatch:
    styles = RobotStyles.of(trace.robot)
    label = str(trace.robot)
    if robots <= MAX_ACCOUNTS:
        label += f": {counted(len(trace.nodes), unit)}, {trace.distance_m:,.0f} m"
    return Swatch(label=label, area=styles.area, line=styles.edge)


def _unit(traces: list[Trace], *, in_full: bool = False) -> str:
    # The word for a node. Scans are counted that showed something new.
    scan = "informative scan" if in_full else "scan"
    return scan if any(trace.scans for trace in traces) else "node"


def _faults(recording: Recording) -> str:
    # Deaths and failures of the radio or of the start, by robot.
    told = {
        Died: "died: {}",
        FellSilent: "fell silent: {}",
        CameBack: "heard again: {}",
        Joined: "joined late: {}",
    }
    parts = []
    for kind, words in told.items():
        who = [
            f"robot {event.robot} at {event.time_s:,.0f} s"
            for event in recording.events
            if isinstance(event, kind)
        ]
        if who:
            parts.append(words.format(", ".join(who)))
    return "; ".join(parts)
