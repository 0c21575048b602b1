"""The measures of a run: their names and definitions."""

from __future__ import annotations

import msgspec

from multisrt.extras.notebook import table_html
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import RunOutcome

ROUNDING = 1e-9
"""Tolerance of shares: an area that is covered completely counts as such."""

SUCCESS_COVERAGE = 0.95
"""Share of the explorable area that a run covers if it is a success, unless another is asked."""


def require_threshold(threshold: float) -> float:
    """Return a share of coverage; raise an `InvalidInputError` unless 0 < share <= 1."""
    if not is_between(threshold, 0.0, 1.0):
        raise InvalidInputError(
            f"a threshold of coverage is a share above 0 and up to 1, not {threshold!r}"
        )
    return threshold


def is_between(value: object, above: float, most: float) -> bool:
    """Whether a value is a number above a lower bound and not above an upper bound."""
    try:
        return bool(above < value <= most)  # type: ignore[operator]
    except (TypeError, ValueError):
        return False


class Metrics(msgspec.Struct, frozen=True, kw_only=True):
    """The measures of a run.

    Every measure has one name, here as in `run.json`, in stored results, in the columns of tables
    and on the command line. `METRIC_GROUPS` lists the names by subject, in the order below.

    Attributes
    ----------
    outcome : {"complete", "stalled", "out_of_time"}
        How the run ended.
    known_complete_s : float or None
        Time at which the first robot knew that its map was complete; None if none did. It counts
        only if that robot knew the area that the team had finally covered; see
        `multisrt.analysis.coverage.known_complete_s`.
    makespan_s : float
        End of the run: all robots are home, if it is complete.
    time_to_90_s, time_to_95_s, time_to_99_s : float or None
        Time at which that share of the explorable area was covered; None if it never was.
    waiting_time_s : float
        Time that all robots together stood still, each between its start and its last end. A
        robot that starts late counts from then, one that dies until then.
    waiting_time_by_robot_s : tuple of float
        The same for each robot.
    total_distance_m : float
        Path length of all robots together.
    distance_by_robot_m : tuple of float
        The same for each robot.
    distance_spread_m : float
        Standard deviation of the path length over all robots of the team.
    coverage : float
        Share of the explorable area that was covered, from 0 to 1: it lies in the safe region of a
        node and was seen; for robots that record no nodes, it was seen.
    seen : float
        Share of the explorable area that any scan showed, from 0 to 1.
    coverage_integral_s : float
        Time integral of the share not yet covered, up to the horizon: lower is better, and
        early coverage counts more.
    free_area_m2 : float
        Area of all free space of the world, reachable or not.
    explorable_area_m2 : float
        Area that any robot could see from the places that its body can reach from its start. Robots
        that die or start late count, because this area is the task of the team.
    covered_area_m2 : float
        Explorable area that was covered.
    seen_area_m2 : float
        Explorable area that was seen.
    unseen_m2 : float
        Explorable area that no robot saw.
    given_up_m2 : dict of str to float
        Explorable area that was not covered, by the reason for which its frontier was given up; see
        `multisrt.analysis.given_up`.
    overlap_area_m2 : float
        Explorable area that at least two robots saw.
    overlap_share : float
        The same as a share of the seen area, from 0 to 1; 0 if nothing was seen.
    frontier_left_m : float
        Length of the frontier left open at the end.
    lost_area_m2 : float
        Explorable area that was seen only by robots that died, and that neither a surviving robot
        nor the base station knows at the end.
    lost_area_by_robot_m2 : tuple of float
        The part of it that each robot saw; area seen by two dead robots counts for both.
    known_to_one_m2s : float
        Time integral (m2 s), up to the horizon, of the area that only one robot and not the base
        station knew: the area that would have been lost with the robot.
    known_to_one_by_robot_m2s : tuple of float
        The same for each robot.
    known_to_one_m2 : float
        The area that only one robot knew at the end, whichever robot it was.
    delivered_coverage : float or None
        Share of the explorable area that the base station knew at the end, from 0 to 1: covered
        by nodes that it received in messages. This and the next measures up to `carrying_s` are
        None in a run without a base station; see `multisrt.analysis.delivery`.
    delivered_90_s, delivered_95_s, delivered_99_s : float or None
        Time at which that share was delivered; None also if it never was.
    delivery_delay_s : float or None
        Mean delivery delay: the time from the covering of an area to its delivery, averaged over
        the covered area; area that was not delivered counts up to the horizon.
    carrying_s : float or None
        Time during which a robot had undelivered data, averaged over all robots.
    isolated_total_s : float
        Time during which at least one robot was isolated from all other active robots; see
        `multisrt.analysis.isolation` for this and the next measures.
    isolated_by_robot_s : tuple of float
        The isolation time of each robot.
    isolated_longest_s : float
        Duration of the longest spell of one robot.
    beyond_range_m : float or None
        The largest distance of an isolated robot to the nearest other one, minus the range of the
        radio; 0 if there was none, None for a radio of unlimited range.
    split_s : float
        Time during which some robot could not have reached another one.
    messages : int
        Number of messages sent, whether or not any robot received them; in all measures of messages
        the base station counts like a robot.
    deliveries : int
        Number of receptions of messages, relayed or not.
    lost_deliveries : int
        Number of receptions within range that failed because of loss.
    bytes_sent : int
        Size of all messages, each counted once.
    messages_by_kind, bytes_by_kind : dict of str to int
        The same by type of message.
    nodes : int
        Nodes of all trees.
    nodes_by_robot : tuple of int
        The same for each robot.
    nodes_by_stage : dict of str to int
        The same by how their places were found; see `multisrt.events.NodeAdded`.
    decisions : int
        Number of choices of a goal by robots of the SRT family, and of decisions recorded by
        user-defined explorers (`Decision` and `Decided` of `multisrt.events`).
    coordinations : int
        Number of times that a master organised its group.
    deadlocks : int
        Number of times that a master could send no robot.
    arcs_closed : dict of str to int
        Frontier arcs that were given up, by reason.
    diagram_left : dict of str to int
        Number of times that robots that steer by the nearness diagram changed to following their
        path for the rest of a drive, by reason; see `multisrt.events.DiagramLeft`.
    bids_by_radius : dict of str to int
        Number of choices of a goal by robots with self-bidding, by the radius of cohesion; see
        `multisrt.analysis.bids.bids_by_radius`.
    collisions : int
        Number of collisions; 0 in a valid run.
    protective_stops : int
        Number of motions that ended before the body of another robot.
    deaths : int
        Number of robots that died.
    min_clearance_m : float
        Minimum distance between a body and an obstacle during the run.
    min_distance_between_robots_m : float or None
        Minimum distance between two bodies during the run; None for a single robot.
    lower_bound_s : float
        Lower bound on the time in which any team, whatever it knows, can see the share of the
        explorable area that this run covered: the largest of the next bounds. See
        `multisrt.analysis.bounds`.
    lower_bound_reach_s : float
        Time to come within range of the farthest area.
    lower_bound_area_s : float
        Time to sweep the area with range finders that never see a point twice.
    lower_bound_witness_s : float or None
        Time to visit places no two of which are visible at once; None if not requested.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, RunSpec, measure, simulate
    >>> spec = RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1)
    >>> metrics = measure(simulate(spec))
    >>> metrics.outcome, metrics.collisions, metrics.coverage > 0.99
    ('complete', 0, True)
    >>> {name: getattr(metrics, name) for name in METRIC_GROUPS["radio"]}["messages"]
    0
    """

    outcome: RunOutcome
    known_complete_s: float | None
    makespan_s: float
    total_distance_m: float
    distance_by_robot_m: tuple[float, ...]
    distance_spread_m: float
    waiting_time_s: float
    waiting_time_by_robot_s: tuple[float, ...]
    coverage: float
    seen: float
    coverage_integral_s: float
    free_area_m2: float
    explorable_area_m2: float
    covered_area_m2: float
    seen_area_m2: float
    unseen_m2: float
    given_up_m2: dict[str, float]
    overlap_area_m2: float
    overlap_share: float
    lost_area_m2: float
    lost_area_by_robot_m2: tuple[float, ...]
    isolated_total_s: float
    isolated_by_robot_s: tuple[float, ...]
    isolated_longest_s: float
    beyond_range_m: float | None
    split_s: float
    known_to_one_m2s: float
    known_to_one_by_robot_m2s: tuple[float, ...]
    known_to_one_m2: float
    time_to_90_s: float | None
    time_to_95_s: float | None
    time_to_99_s: float | None
    nodes: int
    nodes_by_robot: tuple[int, ...]
    nodes_by_stage: dict[str, int]
    decisions: int
    coordinations: int
    deadlocks: int
    protective_stops: int
    deaths: int
    messages: int
    deliveries: int
    lost_deliveries: int
    bytes_sent: int
    messages_by_kind: dict[str, int]
    bytes_by_kind: dict[str, int]
    arcs_closed: dict[str, int]
    frontier_left_m: float
    collisions: int
    min_clearance_m: float
    min_distance_between_robots_m: float | None
    lower_bound_s: float
    lower_bound_reach_s: float
    lower_bound_area_s: float
    lower_bound_witness_s: float | None
    diagram_left: dict[str, int] = {}
    bids_by_radius: dict[str, int] = {}
    delivered_coverage: float | None = None
    delivered_90_s: float | None = None
    delivered_95_s: float | None = None
    delivered_99_s: float | None = None
    delivery_delay_s: float | None = None
    carrying_s: float | None = None

    def reached(self, threshold: float = SUCCESS_COVERAGE) -> bool:
        """Whether the run was successful: it covered enough, however it ended.

        Parameters
        ----------
        threshold : float
            Share of the explorable area, above 0 and up to 1.

        Raises
        ------
        InvalidInputError
            If the threshold is out of range.
        """
        return self.coverage >= require_threshold(threshold) - ROUNDING

    def outline(self) -> list[tuple[str, str]]:
        """Return the main measures with their names, as text.

        Returns
        -------
        list of (str, str)
            Coverage, times, distance, effort and collisions; waiting and messages of a team only.

        Examples
        --------
        >>> import multisrt as ms
        >>> ms.explore("open", seed=1).metrics.outline()[-1]
        ('collisions', '0')
        """
        is_team = len(self.distance_by_robot_m) > 1
        covered = f"{100.0 * self.coverage:.1f} % of {self.explorable_area_m2:,.1f} m2 explorable"
        rows = [
            ("covered", covered),
            ("95 % covered at", _seconds(self.time_to_95_s)),
            *self._delivered(),
            ("map known complete at", _seconds(self.known_complete_s)),
            ("ended at (makespan)", _seconds(self.makespan_s)),
            ("lower bound of the makespan", _seconds(self.lower_bound_s)),
            ("distance", f"{self.total_distance_m:,.1f} m"),
        ]
        if is_team:
            rows.append(("waiting", _seconds(self.waiting_time_s)))
            rows.append(("messages", f"{self.messages:,} ({self.bytes_sent / 1e6:,.2f} MB)"))
        # As in pictures: the nodes of robots that map by scans on the way are such scans.
        nodes = "informative scans" if "scan" in self.nodes_by_stage else "nodes"
        return [*rows, (nodes, f"{self.nodes:,}"), ("collisions", str(self.collisions))]

    def _delivered(self) -> list[tuple[str, str]]:
        if self.delivered_coverage is None:
            return []
        return [
            ("delivered to the base", f"{100.0 * self.delivered_coverage:.1f} %"),
            ("95 % delivered at", _seconds(self.delivered_95_s)),
        ]

    def _repr_html_(self) -> str:
        rows = [
            (subject if name == names[0] else "", name, _shown(getattr(self, name)))
            for subject, names in METRIC_GROUPS.items()
            for name in names
        ]
        return table_html("Metrics", ["subject", "metric", "value"], rows, labels=3)


def _seconds(value: float | None) -> str:
    return "never" if value is None else f"{value:,.1f} s"


def _shown(value: object) -> str:
    match value:
        case None:
            return "none"
        case float():
            return f"{value:,.3f}".rstrip("0").rstrip(".")
        case dict():
            return ", ".join(f"{name}: {_shown(own)}" for name, own in value.items()) or "none"
        case tuple():
            return ", ".join(map(_shown, value))
        case _:
            return str(value)


METRIC_GROUPS: dict[str, tuple[str, ...]] = {
    "time": (
        "outcome",
        "known_complete_s",
        "makespan_s",
        "time_to_90_s",
        "time_to_95_s",
        "time_to_99_s",
        "waiting_time_s",
        "waiting_time_by_robot_s",
    ),
    "distance": ("total_distance_m", "distance_by_robot_m", "distance_spread_m"),
    "area": (
        "coverage",
        "seen",
        "coverage_integral_s",
        "free_area_m2",
        "explorable_area_m2",
        "covered_area_m2",
        "seen_area_m2",
        "unseen_m2",
        "given_up_m2",
        "overlap_area_m2",
        "overlap_share",
        "frontier_left_m",
    ),
    "knowledge": (
        "lost_area_m2",
        "lost_area_by_robot_m2",
        "known_to_one_m2s",
        "known_to_one_by_robot_m2s",
        "known_to_one_m2",
    ),
    "base": (
        "delivered_coverage",
        "delivered_90_s",
        "delivered_95_s",
        "delivered_99_s",
        "delivery_delay_s",
        "carrying_s",
    ),
    "isolation": (
        "isolated_total_s",
        "isolated_by_robot_s",
        "isolated_longest_s",
        "beyond_range_m",
        "split_s",
    ),
    "radio": (
        "messages",
        "deliveries",
        "lost_deliveries",
        "bytes_sent",
        "messages_by_kind",
        "bytes_by_kind",
    ),
    "effort": (
        "nodes",
        "nodes_by_robot",
        "nodes_by_stage",
        "decisions",
        "coordinations",
        "deadlocks",
        "arcs_closed",
        "diagram_left",
        "bids_by_radius",
    ),
    "safety": (
        "collisions",
        "protective_stops",
        "deaths",
        "min_clearance_m",
        "min_distance_between_robots_m",
    ),
    "bounds": (
        "lower_bound_s",
        "lower_bound_reach_s",
        "lower_bound_area_s",
        "lower_bound_witness_s",
    ),
}
"""The names of all metrics by subject; each subject is measured by its own function."""
