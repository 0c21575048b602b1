"""Notes on a base station that robots do not reach, or that lacks data."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from multisrt.environments.area_text import area_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from multisrt.environments.environment import Environment
    from multisrt.finished_run import Run
    from multisrt.geometry.configuration import Configuration
    from multisrt.recording import Recording
    from multisrt.spec import RunSpec

BODY_LENGTHS = 2.0
"""A body gets to a place if it can be as near to it as this, in its circumscribed radii."""


def base_apart(spec: RunSpec, environment: Environment, starts: Sequence[Configuration]) -> str:
    """Return a note if no robot can drive to the base station; empty if one can.

    Parameters
    ----------
    spec : RunSpec
        The run.
    environment : Environment
        Its world.
    starts : sequence of Configuration
        Where the robots start.

    Returns
    -------
    str
        What bars them, and whether radio can reach the base station nevertheless.

    Examples
    --------
    >>> import shapely
    >>> import multisrt as ms
    >>> from multisrt.environments.environment import Environment
    >>> from multisrt.geometry.configuration import Configuration
    >>> two = Environment("two rooms", shapely.box(0, 0, 2, 2) | shapely.box(3, 0, 6, 2))
    >>> spec = ms.RunSpec(
    ...     environment=ms.CatalogEnvironment(name="open"),
    ...     base=ms.BaseSpec(x=1.0, y=1.0),
    ...     radio=ms.RadioSpec(walls="block"),
    ... )
    >>> base_apart(spec, two, [Configuration(4.0, 1.0, 0.0)])
    'no robot can drive to the base station (1, 1), which is in another part of free space (of \
4 m2); walls block the radio: it will learn nothing'
    """
    import shapely

    from multisrt.analysis.explorable import reachable_area, viewers

    if spec.base is None:
        return ""
    x, y = spec.base.place
    here, place = environment.component(x, y), shapely.Point(x, y)
    is_apart = environment.component(*starts[0][:2]) is not here
    nearest_m = []
    for body, _, start in viewers(spec, starts):
        reached = reachable_area(environment.component(*start[:2]), body, start)
        nearest_m.append(float(reached.distance(place)))
        if not is_apart and nearest_m[-1] <= BODY_LENGTHS * body.circumscribed_radius_m:
            return ""
    barred = (
        f"which is in another part of free space (of {area_text(here.area)} m2)"
        if is_apart
        else "as passages are too narrow"
    )
    said = f"no robot can drive to the base station ({x:g}, {y:g}), {barred}"
    range_m = spec.radio.range_m
    if range_m is not None and min(nearest_m) > range_m:
        return f"{said}; none comes within radio range ({range_m:g} m): it will learn nothing"
    if is_apart and spec.radio.walls == "block":
        return f"{said}; walls block the radio: it will learn nothing"
    return f"{said}; it learns only what reaches it by radio from elsewhere"


def not_delivered(run: Run) -> str:
    """Return a note if the base station learned nothing, or lacks data of robots that deliver it.

    It is empty if there is nothing to tell, or no base station.

    Parameters
    ----------
    run : Run
        The run.

    Returns
    -------
    str
        The reason as far as the recording shows it: whether a robot was in reach, and if not, what
        may bring one there.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore(
    ...     "open", starts=[(1.0, 1.0)], base=(9.0, 9.0), radio_range_m=2.0, max_time_s=5.0
    ... )
    >>> not_delivered(run)
    'the base station learned nothing: no robot was in reach of its radio (2 m); robots go there \
with --option home=in-time'
    """
    import msgspec

    from multisrt.analysis.radio_links import radio_links
    from multisrt.events import BaseLearned, NodeAdded, Sent
    from multisrt.robots.registry import strategy

    recording, spec = run.recording, run.spec
    if spec.base is None:
        return ""
    if recording.of(BaseLearned):
        return _lacking(recording)
    said = "the base station learned nothing"
    sends_nodes = bool(recording.of(NodeAdded)) and bool(recording.of(Sent))
    if not sends_nodes:
        return f"{said}: robots of {spec.strategy} send no nodes, which are what it learns"
    base = len(spec.robots)
    links = radio_links(recording, run.environment)
    linked_s = sum(
        until - begin for pair, spells in links.items() if base in pair for begin, until in spells
    )
    if linked_s > 0.0:
        return (
            f"{said}, though robots were in reach of its radio for {linked_s:.1f} s: no message "
            "with nodes arrived"
        )
    range_m = spec.radio.range_m
    reach = "" if range_m is None else f" ({range_m:g} m)"
    said = f"{said}: no robot was in reach of its radio{reach}"
    if base_apart(spec, run.environment, recording.starts):
        return f"{said}; they cannot drive there"
    if spec.options.get("home", "never") == "never":
        fields = msgspec.structs.fields(strategy(spec.strategy).options)
        may_go = any(field.name == "home" and field.default == "never" for field in fields)
        return f"{said}{'; robots go there with --option home=in-time' * may_go}"
    if run.outcome == "out_of_time":
        return (
            f"{said} within the time limit of {spec.stop.max_time_s:g} s, as none found a way "
            f"there in time; allow more with --max-time, or {_remedy(spec)}"
        )
    return f"{said}; they ended before they found a way there"


def _lacking(recording: Recording) -> str:
    """Return which robots that live ended with scans that the base station lacks, if they bring it.

    Without an option `home` robots bring nothing, and what is lacking is a measure of the run.
    """
    from multisrt.events import BaseLearned, Died, NodeAdded
    from multisrt.explain.home import delivers, knows_contact
    from multisrt.robots.naming import named_robots

    if not delivers(recording):
        return ""
    known = {tuple(name) for event in recording.of(BaseLearned) for name in event.nodes}
    dead = {event.robot for event in recording.of(Died)}
    counts = Counter(
        node.robot
        for node in recording.of(NodeAdded)
        if node.robot not in dead and (node.robot, node.serial) not in known
    )
    if not counts:
        return ""
    their = "their" if len(counts) > 1 else "its"
    said = f"{named_robots(counts)} did not bring home {counts.total()} of {their} scans"
    lost = [robot for robot in counts if not knows_contact(recording, robot)]
    if not lost:
        return f"{said}: see multisrt why"
    who = named_robots(lost) if len(lost) < len(counts) else "they" if len(lost) > 1 else "it"
    others = "" if len(lost) == len(counts) else "; of the others see multisrt why"
    return (
        f"{said}: {who} knew no place where the base station is certain to hear a robot; "
        f"{_remedy(recording.spec)}{others}"
    )


def _remedy(spec: RunSpec) -> str:
    if spec.starts == "base":
        return "move the base station away from walls"
    return "start robots there (--starts base)"
