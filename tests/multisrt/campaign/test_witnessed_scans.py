"""Scans, data sheets, news and the end of a run, as seen by its witness."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import shapely

from multisrt.campaign.witness import Witness
from multisrt.campaign.witness.datasheets import told_what_they_are
from multisrt.campaign.witness.sample import Sample
from multisrt.campaign.witness.scans import Scanned, scans_show_walls
from multisrt.environments.environment import Environment
from multisrt.events import BaseLearned, Died, Learned, Sent
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.boundary import GAP, OBSTACLE, RANGE
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.scan import take_scan
from multisrt.robots.explorer import Done, Receive, Received, Send
from multisrt.robots.knowledge import Node, NodeId
from multisrt.robots.messages import Message
from multisrt.simulation.setting_up import set_up
from multisrt.spec import (
    BaseSpec,
    CatalogEnvironment,
    LateStart,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    StopRule,
)
from tests.multisrt.campaign.tampering import written

WALLED = Environment(
    "walled", shapely.box(0.0, 0.0, 8.0, 6.0).difference(shapely.box(2.4, 0.0, 2.6, 2.5))
)
AT = Configuration(1.0, 1.5, 0.0)


def scan_of(beams, range_m=4.0):
    return take_scan(EdgeIndex(WALLED.edges, 1.0), AT, 1.0, range_m, beams)


def says(scan, beams=None, range_m=4.0, time_s=1.0):
    finder = RangeFinderSpec(range_m=range_m, beams=beams)
    robots = (RobotSpec(range_finder=finder),)
    run = written(starts=((1.0, 1.5, 0.0),), environment=WALLED, robots=robots)
    found = next(scans_show_walls(run, [Scanned(0, time_s, scan)]), None)
    return None if found is None else found.says


def test_scans_of_walls_are_right():
    assert says(scan_of(None)) is None
    assert says(scan_of(64), beams=64) is None
    assert says(scan_of(360), beams=360) is None


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda r: r - 0.001, "reads 1.3990 m at 0.000 rad, where a wall is 1.4000 m away"),
        (lambda r: r + 0.001, "reads 1.4010 m at 0.000 rad, where a wall is 1.4000 m away"),
        (lambda r: np.where(r < 1.45, np.inf, r), "reads inf m at 0.000 rad"),
        (lambda r: np.minimum(r, 3.0), "reads 3.0000 m at"),
    ],
)
def test_wrong_readings_are_found(change, text):
    scan = scan_of(64)
    found = says(replace(scan, ranges=change(scan.ranges)), beams=64)
    assert text in found


@pytest.mark.parametrize(
    ("tag", "text"), [(OBSTACLE, "a wall"), (RANGE, "no wall"), (GAP, "not on a line of sight")]
)
def test_wrong_borders_are_found(tag, text):
    scan = scan_of(None)
    here = np.array([AT.x, AT.y])
    boundary = scan.boundary.copy()
    piece = int(np.flatnonzero(scan.tags == tag)[0])
    if tag == GAP:
        boundary[piece] += 0.01 * (np.array([[0, -1], [1, 0]]) @ (boundary[piece] - here))
        # The wall before the gap ends elsewhere, too.
        tags = np.where(scan.tags == OBSTACLE, RANGE, scan.tags) * 0 + GAP
        scan = replace(scan, tags=tags.astype(np.int8))
    else:
        boundary[piece] = here + 0.98 * (boundary[piece] - here)
    assert text in says(replace(scan, boundary=boundary))


def test_an_exact_scan_that_sees_through_a_wall_is_found():
    free = shapely.box(0.0, 0.0, 8.0, 6.0)
    assert "sees through a wall" in says(
        take_scan(EdgeIndex(Environment("hall", free).edges, 1.0), AT, 1.0, 4.0, None)
    )


def test_an_exact_scan_that_leaves_a_sector_out_is_found():
    scan = scan_of(None)
    walls = np.flatnonzero(scan.tags == OBSTACLE)
    at = int(walls[len(walls) // 2]) + 1
    here = np.array([[AT.x, AT.y]])
    boundary = np.insert(scan.boundary, at, here, axis=0)
    tags = np.insert(scan.tags, at, np.int8(GAP))
    tags[at - 1] = GAP
    assert "has a gap at no corner" in says(replace(scan, boundary=boundary, tags=tags))


def test_a_scan_is_of_where_and_when_the_robot_is():
    scan = scan_of(64)
    moved = replace(scan, configuration=Configuration(1.01, 1.5, 0.0))
    assert says(moved, beams=64).endswith("is not of where it is")
    assert "is of 1.000 s" in says(scan, beams=64, time_s=2.0)
    assert "with a range of 4 m" in says(scan, beams=64, range_m=5.0)
    assert says(scan, beams=65).endswith("has 64 beams")
    assert says(scan_of(None), beams=65).endswith("has no beams")


# Data sheets ------------------------------------------------------------------------------------


def two(**more):
    return RunSpec(
        environment=CatalogEnvironment(name="open"),
        robots=(RobotSpec(), RobotSpec(range_finder=RangeFinderSpec(range_m=3.0))),
        radio=RadioSpec(range_m=20.0, latency_s=0.1, jitter_s=0.2, loss=0.1, walls="block"),
        base=BaseSpec(x=5.0, y=5.0),
        faults=(LateStart(robot=1, time_s=3.0),),
        stop=StopRule(max_time_s=50.0),
        **more,
    )


@pytest.mark.parametrize("strategy", ["minpos", "srt-star"])
def test_robots_are_told_what_the_spec_says(strategy):
    assert list(told_what_they_are(set_up(two(strategy=strategy)))) == []


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("limit_s", 100.0),
        ("time_s", 0.0),
        ("range_m", 4.0),
        ("team", 3),
        ("start", AT),
        ("base", (5.0, 5.1)),
        ("radio.latency_s", 0.1),
        ("radio.reaches_all", True),
        ("rng", None),
    ],
)
def test_other_values_are_found(field, value):
    setup = set_up(two(strategy="minpos"))
    explorers: Any = setup.explorers
    first, second = explorers
    me = second.robot.me
    if field == "rng":
        me = replace(me, rng=first.robot.me.rng)
    elif field.startswith("radio."):
        me = replace(me, radio=replace(me.radio, **{field.removeprefix("radio."): value}))
    else:
        me = replace(me, **{field: value})
    told: Any = SimpleNamespace(robot=SimpleNamespace(me=me))
    setup = replace(setup, explorers=(first, told))
    [found] = told_what_they_are(setup)
    assert found.says == f"robot 1 is told wrong values of {field}"


# News, and the end ------------------------------------------------------------------------------


class Report(Message, frozen=True):
    entries: tuple[Node, ...]


def node(robot, serial):
    region: Any = None
    return Node(id=NodeId(robot, serial), configuration=AT, region=region, parent=None, time_s=0.0)


class Told:
    """Robots 0 and 1, and the base station 2, which are told of nodes."""

    def __init__(self, **radio):
        self.run = written(
            starts=((1.0, 1.5, 0.0), (3.0, 1.5, 0.0)),
            radio=RadioSpec(**radio),
            base=BaseSpec(x=2.0, y=1.0),
            end_s=20.0,
        )
        setup: Any = SimpleNamespace(spec=self.run.recording.spec, explorers=())
        self.witness = Witness(setup)

    def send(self, time_s, message, *reached):
        self.witness.overhear(0, time_s, None, Send(message=message, to=None))
        sent = Sent(
            time_s=time_s, robot=0, kind=message.kind, size_bytes=1, reached=reached, lost=()
        )
        self.witness.watch(sent)

    def says(self):
        found = self.witness.violations(self.run)
        return [one.says for one in found if one.invariant != "messages-arrive"]


def test_robots_learn_what_was_in_messages():
    told, report = Told(), Report((node(0, 3),), sender=0)
    told.send(1.0, report, 1)
    told.witness.overhear(1, 0.0, None, Receive())
    told.witness.overhear(1, 1.0, Received((report,), 1.0), Receive())
    told.witness.watch(Learned(time_s=1.0, robot=1, nodes=((0, 3), (1, 7))))
    assert told.says() == []
    told.witness.watch(Learned(time_s=1.0, robot=1, nodes=((0, 4),)))
    assert told.says() == ["robot 1 learns of node (0, 4), which nobody told it"]


@pytest.mark.parametrize(
    ("learned_s", "text"),
    [
        (1.5, None),
        (2.0, None),
        (2.5, "the base station learns of node (0, 3) only at 2.500 s, not by 2.000 s"),
        (None, "the base station does not learn of node (0, 3), told by 2.000 s"),
    ],
)
def test_the_base_station_learns_what_reaches_it_in_time(learned_s, text):
    told = Told(latency_s=0.5, jitter_s=0.5)
    told.send(1.0, Report((node(0, 3),), sender=0), 2)
    if learned_s is not None:
        told.witness.watch(BaseLearned(time_s=learned_s, robot=0, nodes=((0, 3),)))
    assert told.says() == ([] if text is None else [text])


def test_the_base_station_learns_nothing_else():
    told = Told()
    told.send(1.0, Report((node(0, 3),), sender=0), 1)
    told.witness.watch(BaseLearned(time_s=1.0, robot=0, nodes=((0, 3),)))
    assert told.says() == ["the base station learns of node (0, 3), which nobody told it"]


@pytest.mark.parametrize(
    ("done_s", "sent_s", "died", "text"),
    [
        (20.0, 0.0, False, None),
        (5.0, 19.5, False, None),  # a message is on its way to the end
        (5.0, 0.0, True, None),
        (5.0, 0.0, False, "the run ends at 20.000 s, and all robots at 5.000 s"),
        (5.0, 4.9, False, "the run ends at 20.000 s, and all robots at 5.400 s"),
    ],
)
def test_a_run_ends_when_all_robots_have(done_s, sent_s, died, text):
    told = Told(latency_s=0.5)
    told.send(sent_s, Report((), sender=0), 1)
    told.witness.overhear(0, 5.0, None, Done(complete=True, reason="done"))
    if died:
        told.witness.watch(
            Died(time_s=20.0, robot=1, configuration=(0.0, 0.0, 0.0), doing="waiting")
        )
    else:
        told.witness.overhear(1, done_s, None, Done(complete=True, reason="done"))
    assert told.says() == ([] if text is None else [text])


def test_a_run_goes_on_while_a_robot_waits():
    told = Told()
    told.witness.overhear(0, 5.0, None, Done(complete=True, reason="done"))
    told.witness.overhear(1, 5.0, None, Receive(timeout_s=math.inf))
    assert told.says() == []


def test_samples_are_spread_over_all():
    sample = Sample[int](8)
    for number in range(1000):
        sample.add(number)
    assert 4 <= len(sample.items) < 8
    assert len({b - a for a, b in zip(sample.items, sample.items[1:], strict=False)}) == 1
    assert sample.items[-1] > 700
