"""What an animation shows when: the contents of its pictures, whatever draws them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from multisrt.analysis.activity import Activity, activities
from multisrt.analysis.run_tables import coverage_curve
from multisrt.drawing.account import run_title
from multisrt.drawing.animation.growth import Piece, pieces
from multisrt.drawing.animation.keyframes import Way, ways_of
from multisrt.drawing.animation.layout import MAX_ENTRIES, Layout, layout_of
from multisrt.drawing.animation.pace import Pace
from multisrt.drawing.colours import NODE_MM, STAGE_MARKERS
from multisrt.drawing.layers import PICTURES, left_out
from multisrt.drawing.svg import Marker
from multisrt.drawing.traces import median_edge_m, traces_of
from multisrt.environments.environment import Environment
from multisrt.events import (
    Coordinated,
    Decided,
    Decision,
    Died,
    Ended,
    GoalChosen,
    NodeAdded,
    NodeName,
    Point,
)
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.recording import Recording

WAY_TOLERANCE_PX: Final = 0.25
AREA_TOLERANCE_PX: Final = 0.4
"""Bounds of the differences between what is drawn and what is true, in pixels of the picture."""

MIN_BODY_PX: Final = 7.0
"""Bodies of a smaller circumscribed radius are enlarged to it, in a picture of default width."""

NODE_SHARE: Final = 0.2
"""Radius of a node as a share of the median edge, clipped to `NODE_MM`."""


class Edge(NamedTuple):
    """An edge of a tree, from the parent to the new node."""

    picture: int
    robot: int
    ends: tuple[Point, Point]


class Dot(NamedTuple):
    """A node of a tree."""

    picture: int
    robot: int
    marker: Marker
    place: Point


class Span(NamedTuple):
    """Something that is shown from a picture until another; the last one stays."""

    begin: int
    end: int
    shown: str


class Goal(NamedTuple):
    """A goal that a robot has from a picture on; None for no goal."""

    picture: int
    place: Point | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Actor:
    """A robot.

    Attributes
    ----------
    way : Way
        Where it is drawn when.
    outline : (n, 2) array
        Its body about its reference point, in metres, not smaller than can be seen.
    radius_m : float or None
        The radius of that if it is a disc.
    has_tree : bool
        Whether edges of trees are its own.
    goals : list of Goal
        Its goals, in order.
    activities : list of Span
        What it does, in order and without gaps.
    """

    way: Way
    outline: FloatArray
    radius_m: float | None
    has_tree: bool
    goals: list[Goal]
    activities: list[Span]

    @property
    def outer_m(self) -> float:
        """Radius of a circle around the reference point that holds the body, in metres."""
        return float(np.hypot(*self.outline.T).max())

    @property
    def front_m(self) -> float:
        """Distance from the reference point to the front, in metres."""
        return float(self.outline[:, 0].max())


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """The contents of an animation.

    Attributes
    ----------
    environment : Environment
        The world.
    title : str
        What is shown.
    pace : Pace
        When its pictures are shown.
    layout : Layout
        Where its parts are.
    layers : frozenset of str
        What is shown.
    node_mm : float
        Radius of nodes.
    pieces, edges, dots : lists
        What appears, in order.
    actors : list of Actor
        The robots.
    captions : list of Span
        Time and coverage as text.
    base : (x, y) or None
        The place of the base station, in metres.
    """

    environment: Environment
    title: str
    pace: Pace
    layout: Layout
    layers: frozenset[str]
    node_mm: float
    pieces: list[Piece]
    edges: list[Edge]
    dots: list[Dot]
    actors: list[Actor]
    captions: list[Span]
    base: Point | None = None

    @property
    def team(self) -> bool:
        """Whether there are several robots."""
        return len(self.actors) > 1


def scene_of(
    recording: Recording,
    environment: Environment,
    pace: Pace,
    *,
    width: int,
    height: int | None = None,
    without: Collection[str] = (),
) -> Scene:
    """Return the contents of an animation of a run.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment
        Its world.
    pace : Pace
        When what is shown.
    width, height : int
        Size of the pictures in pixels; without a height, what the map needs.
    without : collection of str
        Layers to leave out: names of `multisrt.drawing.layers.PICTURES` of an animation.

    Returns
    -------
    Scene
        The contents, without the layers that are left out.

    Raises
    ------
    InvalidInputError
        If the recording contradicts itself, a layer is unknown, or the size is out of range.
    """
    layers = frozenset(PICTURES["animation"]) - left_out(without, "animation")
    robots, captioned = len(recording.starts), "caption" in layers
    layout = layout_of(environment.bounds, robots, width, height, captioned=captioned)
    traces = traces_of(recording)
    px_m = 1.0 / layout.scale
    edge_m = median_edge_m(traces)
    node_mm = NODE_MM[1] if edge_m is None else NODE_SHARE * edge_m / layout.mm
    base = recording.spec.base
    edges, dots = _trees(recording, pace)
    edges = edges if "edges" in layers else []
    dots = dots if "nodes" in layers else []
    areas = pieces(recording, environment, pace, AREA_TOLERANCE_PX * px_m)
    return Scene(
        environment=environment,
        title=run_title(recording),
        pace=pace,
        layout=layout,
        layers=layers,
        node_mm=float(np.clip(node_mm, *NODE_MM)),
        pieces=list(areas) if "areas" in layers else [],
        edges=edges,
        dots=dots,
        actors=_actors(recording, environment, pace, layout, {edge.robot for edge in edges}),
        captions=_captions(recording, environment, pace) if captioned else [],
        base=None if base is None or "base" not in layers else base.place,
    )


def _trees(recording: Recording, pace: Pace) -> tuple[list[Edge], list[Dot]]:
    at: dict[NodeName, Point] = {}
    edges, dots = [], []
    for node in recording.of(NodeAdded):
        picture, place = pace.picture_after(node.time_s), node.configuration[:2]
        at[node.robot, node.serial] = place
        if node.stage == "scan":
            continue
        if node.parent is not None:
            edges.append(Edge(picture, node.robot, (at[node.parent], place)))
        if node.stage in STAGE_MARKERS:
            dots.append(Dot(picture, node.robot, STAGE_MARKERS[node.stage], place))
    return edges, dots


def _actors(
    recording: Recording,
    environment: Environment,
    pace: Pace,
    layout: Layout,
    with_trees: Collection[int],
) -> list[Actor]:
    goals = _goals(recording, pace)
    spells = activities(recording, environment)
    ways = ways_of(recording, WAY_TOLERANCE_PX / layout.scale)
    min_body_m = MIN_BODY_PX * layout.unit / layout.scale
    actors = []
    for robot, spec in enumerate(recording.spec.robots):
        body = Footprint.parse(spec.footprint)
        larger = max(1.0, min_body_m / body.circumscribed_radius_m)
        actors.append(
            Actor(
                way=ways[robot],
                outline=larger * body.vertices,
                radius_m=larger * body.circumscribed_radius_m if body.is_disc else None,
                has_tree=robot in with_trees,
                goals=goals[robot],
                activities=_by_picture(
                    [(s.start_s, s.end_s, s.activity) for s in spells[robot]], pace
                ),
            )
        )
    return actors


def _by_picture(spells: list[tuple[float, float, Activity]], pace: Pace) -> list[Span]:
    # What takes most of the time that a picture stands for is shown in it.
    if not spells:
        return [Span(0, pace.last, "waits")]
    borders = pace.run_s * np.arange(pace.last + 1) / pace.last
    most, shown = np.full(pace.last, -1.0), np.zeros(pace.last, np.int64)
    kinds = list(dict.fromkeys(doing for *_, doing in spells))
    for number, kind in enumerate(kinds):
        own = [spell[:2] for spell in spells if spell[2] == kind]
        spent = sum(np.diff(np.clip(borders, begin, end)) for begin, end in own)
        shown[spent > most] = number
        most = np.maximum(most, spent)
    begins = np.flatnonzero(np.diff(shown, prepend=-1)).tolist()
    found = [
        Span(begin, end, kinds[shown[begin]])
        for begin, end in zip(begins, [*begins[1:], pace.last], strict=True)
    ]
    # The last picture shows what is so at the end.
    last = spells[-1][2]
    if found[-1].shown != last:
        found[-1] = found[-1]._replace(end=pace.last)
        found.append(Span(pace.last, pace.last, last))
    return found


def _goals(recording: Recording, pace: Pace) -> dict[int, list[Goal]]:
    goals: dict[int, list[Goal]] = defaultdict(list)
    for picture, robot, place in _choices(recording, pace):
        own = goals[robot]
        if own and own[-1].picture == picture:
            own.pop()
        if (own[-1].place if own else None) != place:
            own.append(Goal(picture, place))
    return goals


def _choices(recording: Recording, pace: Pace) -> Iterator[tuple[int, int, Point | None]]:
    for event in recording.events:
        match event:
            case Decision():
                goes = event.choice not in ("stay", "end")
                place = event.target if goes else None
            case Coordinated():
                place = None if event.order == "wait" else event.new_target
            case GoalChosen() | Decided():
                place = event.goal
            case Ended() | Died():
                place = None
            case _:
                continue
        yield pace.picture_after(event.time_s), event.robot, place


def _captions(recording: Recording, environment: Environment, pace: Pace) -> list[Span]:
    curve = coverage_curve(recording, environment)
    times_s = np.asarray(curve["time_s"].values, np.float64)
    told = {"coverage": "covered", "delivered": "at the base"}
    shares = {name: np.asarray(curve[name].values, np.float64) for name in told if name in curve}
    captions: list[Span] = []
    for picture in range(pace.last + 1):
        now_s = pace.time_s(picture)
        row = np.searchsorted(times_s, now_s + 1e-9, side="right") - 1
        # Rounded down, so that 100 % is the whole.
        percents = [
            f"{np.floor(1000.0 * share[row] + 1e-6) / 10.0:.1f} % {told[name]}"
            for name, share in shares.items()
        ]
        text = ", ".join([f"{_time(now_s, pace.run_s)} s", *percents])
        if captions and captions[-1].shown == text:
            captions[-1] = captions[-1]._replace(end=picture + 1)
        else:
            captions.append(Span(picture, picture + 1, text))
    return captions


def _time(now_s: float, run_s: float) -> str:
    return f"{now_s:,.1f}" if run_s < 20.0 else f"{now_s:,.0f}"


def is_listed(scene: Scene) -> bool:
    """Return whether the robots are listed below the map."""
    return scene.layout.captioned and len(scene.actors) <= MAX_ENTRIES
