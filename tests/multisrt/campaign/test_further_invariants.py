"""Invariants of decisions, speeds, losses, measures, returned data and ends."""

import msgspec
import pytest
import shapely

from multisrt.analysis.isolation import Isolation
from multisrt.analysis.isolation import isolation as isolation_of
from multisrt.analysis.measuring import measure_with_curves
from multisrt.campaign.invariants import INVARIANTS, JudgedRun, isolation, measures
from multisrt.campaign.invariants.open_frontier import stretches
from multisrt.environments.environment import Environment
from multisrt.events import (
    BaseLearned,
    Blocked,
    CameBack,
    Decision,
    Died,
    Ended,
    FellSilent,
    GoalChosen,
    Learned,
    Motion,
    NodeAdded,
    Sent,
)
from multisrt.simulation.simulate import simulate
from multisrt.simulation.standstill import NOTHING_NEW
from multisrt.simulation.worlds import build_environment
from multisrt.spec import (
    BaseSpec,
    CatalogEnvironment,
    Death,
    RadioSpec,
    RobotSpec,
    RunSpec,
    Silence,
    StopRule,
)
from tests.multisrt.campaign.tampering import changed, drive, once, written

replace = msgspec.structs.replace
OPEN = CatalogEnvironment(name="open", parameters={"size_m": 8.0})


def executed(spec):
    environment = build_environment(spec.environment)
    return JudgedRun(recording=simulate(spec, environment), environment=environment)


@pytest.fixture(scope="module")
def bids():
    return executed(
        RunSpec(
            environment=OPEN,
            strategy="minpos",
            options={"home": "in-time"},
            robots=(RobotSpec(),) * 3,
            radio=RadioSpec(range_m=5.0, latency_s=0.1),
            base=BaseSpec(x=1.0, y=1.0),
            stop=StopRule(max_time_s=300.0),
            seed=3,
        )
    )


def says(run, name):
    violation = INVARIANTS[name](run)
    return "" if violation is None else violation.says


NEW = (
    "losses-at-rate",
    "motion-at-full-speed",
    "stops-before-bodies",
    "goals-by-rule",
    "data-is-returned",
    "known-free-is-free",
    "ends",
    "measures-consistent",
    "isolated-without-links",
)


def test_a_good_run_holds_them(bids):
    assert [says(bids, name) for name in NEW] == [""] * len(NEW)


def report(time_s, reached, lost):
    return Sent(time_s=time_s, robot=0, kind="report", size_bytes=9, reached=reached, lost=lost)


@pytest.mark.parametrize(("lost", "finds"), [(200, False), (320, True), (100, True)])
def test_losses_at_another_rate(lost, finds):
    sent = [report(0.01 * k, *(((), (1,)) if k < lost else ((1,), ()))) for k in range(1000)]
    starts = ((1.0, 1.5, 0.0), (3.0, 1.5, 0.0))
    run = written(sent, starts=starts, radio=RadioSpec(loss=0.2))
    found = "of 1000 receptions are lost, by a radio that loses 0.2" in says(run, "losses-at-rate")
    assert found == finds


def test_a_slow_leg():
    run = written([drive(0, (0.0, 2.0, 1.5, 0.0), (1.3, 2.5, 1.5, 0.0))], strategy="closest")
    assert "takes 1.3000 s for a leg, at 0.00 s, for which 1.0000 s" in says(
        run, "motion-at-full-speed"
    )


def test_a_stop_too_far_from_a_body():
    starts = ((1.0, 1.5, 0.0), (3.0, 1.5, 0.0))
    stop = Blocked(time_s=1.0, robot=0, by=1, configuration=starts[0])
    run = written([stop], starts=starts, strategy="closest")
    assert "stopped 1.5000 m before robot 1, guarding 0.1 m" in says(run, "stops-before-bodies")


@pytest.mark.parametrize(("together", "finds"), [(True, True), (False, False)])
def test_losses_of_all_receivers_together(together, finds):
    fates = [((k // 2) % 4 == 0, (k if together else k + 3) // 2 % 4 == 0) for k in range(400)]
    sent = [
        report(
            0.01 * k,
            reached=tuple(n for n in (1, 2) if not fates[k][n - 1]),
            lost=tuple(n for n in (1, 2) if fates[k][n - 1]),
        )
        for k in range(400)
    ]
    starts = ((0.5, 1.5, 0.0), (2.0, 1.5, 0.0), (3.5, 1.5, 0.0))
    run = written(sent, starts=starts, radio=RadioSpec(loss=0.25))
    found = says(run, "losses-at-rate")
    assert found.startswith("messages are lost for all of their receivers, or for none") is finds


@pytest.mark.parametrize(
    ("start_x", "y", "finds"),
    [
        (0.5, 2.03, True),
        (0.5, 2.06, False),  # not nearer than half of 0.1 m
        (1.97, 2.03, False),  # near from the beginning
    ],
)
def test_a_robot_that_drives_past_another_one(start_x, y, finds):
    start = (start_x, y, 0.0)
    motion = drive(0, (0.0, *start), (3.0, 3.5, y, 0.0))
    run = written([motion], starts=(start, (2.0, 1.5, 0.0)), strategy="closest")
    found = says(run, "stops-before-bodies")
    assert ("drives on 0.0" in found and "from robot 1, guarding 0.1 m" in found) is finds


def test_a_robot_that_drives_past_one_behind_a_wall():
    rooms = shapely.box(0.0, 0.0, 4.0, 3.0).difference(shapely.box(1.0, 1.76, 3.0, 1.77))
    motion = drive(0, (0.0, 1.5, 2.03, 0.0), (3.0, 2.5, 2.03, 0.0))
    starts = ((1.5, 2.03, 0.0), (2.0, 1.5, 0.0))
    environment = Environment("rooms", rooms)
    run = written([motion], starts=starts, environment=environment, strategy="closest")
    assert says(run, "stops-before-bodies") == ""


def test_a_goal_of_a_higher_rank(bids):
    def other(chosen):
        return replace(
            chosen,
            goal=chosen.frontiers[0],
            ranks=((9,) * len(chosen.frontiers),) * len(chosen.robots),
            costs=((1.0, *(0.5,) * (len(chosen.frontiers) - 1)),) * len(chosen.robots),
        )

    which = next(
        k
        for k, g in enumerate(bids.recording.of(GoalChosen))
        if len(g.frontiers) > 1 and g.goal is not None
    )
    assert "its goal has rank and cost" in says(
        changed(bids, once(GoalChosen, other, which)), "goals-by-rule"
    )


# Bids whose best matching gives robot 0 the farther target, and ones that leave it without any.
BIDS, NO_BIDS = ((-1.0, -4.0), (1.0, 4.0)), ((None, None), (1.0, 4.0))
TAKEN = (1, 0, 40.0, 0.1)
ROUTE = ((0, 1, 8.0, 2.0), (0, 0, 9.0, 6.0), (1, 2, 7.0, 3.0))


@pytest.mark.parametrize(
    ("rule", "goal", "details", "what"),
    [
        ("self-bidding", 1, {"bids": BIDS}, ""),
        ("self-bidding", 0, {"bids": BIDS}, "no best matching of the bids gives it target 0, or"),
        ("self-bidding", 1, {"bids": NO_BIDS}, ""),
        ("self-bidding", 0, {"bids": NO_BIDS}, "its goal costs 3.000 m, another one 2.000 m"),
        ("gain", 1, {"rounds": (TAKEN, (0, 1, 10.0, 0.25))}, ""),
        ("gain", 1, {"rounds": (TAKEN, (0, 1, 10.0, 3.0))}, "target 1 is worth 3, instead of"),
        ("gain", 0, {"rounds": (TAKEN, (0, 1, 10.0, 0.25))}, "its goal is target 0, and not that"),
        ("routes", 1, {"rounds": ROUTE}, ""),
        ("routes", 0, {"rounds": ROUTE}, "its goal is target 0, the first stop 1"),
        ("routes", 1, {"rounds": (*ROUTE, (1, 1, 8.0, 9.0))}, "a target is on two routes"),
        ("routes", 1, {"rounds": ROUTE[1::-1]}, "lengths fall along a route: [6.0, 2.0]"),
        ("routes", 1, {"rounds": ROUTE[2:]}, ""),
        ("routes", 2, {"rounds": (TAKEN,)}, "its goal costs 9.000 m, another one 2.000 m"),
    ],
)
def test_goals_that_a_rule_does_not_name(rule, goal, details, what):
    targets = ((1.0, 1.0), (3.0, 2.0), (3.5, 0.5))[: 2 if rule == "self-bidding" else 3]
    chosen = GoalChosen(
        time_s=1.0,
        robot=0,
        rule=rule,
        because="news",
        goal=targets[goal],
        frontiers=targets,
        robots=(0, 1),
        costs=((3.0, 2.0, 9.0)[: len(targets)], (5.0, 3.0, 1.0)[: len(targets)]),
        **details,
    )
    run = written([chosen], starts=((2.0, 1.5, 0.0), (1.0, 2.0, 0.0)), strategy=rule)
    found = says(run, "goals-by-rule")
    assert what in found
    assert bool(what) is bool(found)


@pytest.mark.parametrize(("x", "finds"), [(2.0, False), (2.5, True)])
def test_a_single_robot_that_ends_away_from_its_root(x, finds):
    end = Ended(time_s=2.0, robot=0, reason="all is explored", complete=True, frontier=())
    motion = drive(0, (0.0, 2.0, 1.5, 0.0), (1.0, x, 1.5, 0.0))
    run = written([motion, end], strategy="srt-radial")
    assert ("0.500 m from its root" in says(run, "ends-at-home")) == finds


def test_what_the_base_station_never_learned(bids):
    lost = changed(bids, lambda e: None if isinstance(e, BaseLearned) else e)
    assert "but the base station lacks" in says(lost, "data-is-returned")


def test_a_region_that_ends_before_the_range():
    run = executed(
        RunSpec(
            environment=CatalogEnvironment(name="open", parameters={"size_m": 20.0}),
            strategy="closest",
            stop=StopRule(max_time_s=10.0),
        )
    )

    def shorter(node):
        x, y, _ = node.configuration
        return replace(
            node,
            boundary=tuple((x + 0.9 * (cx - x), y + 0.9 * (cy - y)) for cx, cy in node.boundary),
        )

    assert says(run, "known-free-is-free") == ""
    assert "as out of range" in says(changed(run, once(NodeAdded, shorter)), "known-free-is-free")


def test_a_run_that_ends_before_it_stood_still_for_long(bids):
    short = changed(bids, outcome="stalled", reason=f"{NOTHING_NEW} for 3,600 s: robot 0 waits")
    assert "as nothing new came for 3600 s, but something did" in says(short, "ends")


@pytest.mark.parametrize(
    "name",
    [
        "total_distance_m",
        "waiting_time_s",
        "deliveries",
        "nodes",
        "min_clearance_m",
        "coverage_integral_s",
        "carrying_s",
        "delivery_delay_s",
    ],
)
def test_measures_that_are_not_those_of_the_events(bids, name, monkeypatch):
    monkeypatch.setattr(measures, "ONE_IN", 1)
    said, curves = measure_with_curves(bids.recording, bids.environment)
    wrong = replace(said, **{name: 1.5 * getattr(said, name) + 1.0})
    monkeypatch.setattr(measures, "measure_with_curves", lambda *_: (wrong, curves))
    assert name in says(bids, "measures-consistent")


@pytest.mark.parametrize(("seen", "finds"), [(0.985, False), (0.97, True)])
def test_an_informed_plan_that_shows_less_than_it_is_to(seen, finds, monkeypatch):
    monkeypatch.setattr(measures, "ONE_IN", 1)
    run = executed(RunSpec(environment=OPEN, strategy="informed", options={"effort": 0.001}))
    said, curves = measure_with_curves(run.recording, run.environment)
    assert said.seen >= 0.99
    less = replace(said, seen=seen)
    monkeypatch.setattr(measures, "measure_with_curves", lambda *_: (less, curves))
    assert ("by an informed plan for 0.99" in says(run, "measures-consistent")) is finds


# Two robots stand 3 m apart, and hear each other over 2 m only through the base station between
# them; a third one is out of reach of all, and dies at 10 s. The radio of the first is silent from
# 12 to 15 s.
APART = (((1.0, 0.5, 0.0), (1.0, 3.5, 0.0), (8.0, 2.0, 0.0)), (1.0, 2.0))
TRULY = ((12.0, 15.0),), ((12.0, 15.0),), ((0.0, 10.0),)


@pytest.mark.parametrize(
    ("relays", "measured", "what"),
    [
        (True, TRULY, ""),
        (True, (((0.0, 15.0),), *TRULY[1:]), "robot 0 is measured as isolated, but has a link"),
        (True, ((), *TRULY[1:]), "robot 0 has no link, but is not measured as isolated"),
        (True, (*TRULY[:2], ((0.0, 9.0),)), "robot 2 has no link, but is not measured"),
        (False, TRULY, "robot 0 has no link, but is not measured as isolated"),
        (False, (((0.0, 20.0),), ((0.0, 20.0),), TRULY[2]), ""),
    ],
)
def test_isolation_is_that_of_links(relays, measured, what, monkeypatch):
    starts, base = APART
    run = written(
        [
            Died(time_s=10.0, robot=2, configuration=starts[2], doing="waiting"),
            FellSilent(time_s=12.0, robot=0),
            CameBack(time_s=15.0, robot=0),
        ],
        starts=starts,
        environment=Environment("hall", shapely.box(0.0, 0.0, 9.0, 4.0)),
        radio=RadioSpec(range_m=2.0, multi_hop=relays),
        base=BaseSpec(x=base[0], y=base[1]),
        faults=(Death(robot=2, time_s=10.0), Silence(robot=0, time_s=12.0, duration_s=3.0)),
    )
    ones = [Isolation(total_s=0, longest_s=0, beyond_range_m=0, spells=own) for own in measured]
    if not what:  # it is what is measured indeed
        assert tuple(one.spells for one in isolation_of(run.recording)) == measured
    monkeypatch.setattr(isolation, "isolation", lambda *_: ones)
    assert says(run, "isolated-without-links").startswith(what)
    assert bool(what) is bool(says(run, "isolated-without-links"))


@pytest.mark.parametrize(
    ("begin_s", "options", "finds"),
    [
        (20.0, {"home": "in-time"}, False),
        (22.0, {"home": "in-time"}, True),
        (22.0, {"home": "worth"}, True),
        (22.0, {"home": "never"}, False),
        (22.0, {"home": "in-time", "home_reserve_s": 5.0}, False),
    ],
)
@pytest.mark.parametrize("strategy", ["closest", "srt-star"])
def test_a_robot_that_sets_out_too_late(begin_s, options, finds, strategy):
    # 6.02 m from the base station, of which 2 m and two cells are in reach: 7.64 s at 0.5 m/s, a
    # quarter of that, and 10 s in reserve. It has to turn back at 21.45 s.
    room = Environment("hall", shapely.box(0.0, 0.0, 12.0, 3.0))
    nodes = [node_at(1.0, 0), node_at(7.0, 1, time_s=5.0)]
    way = ((begin_s, 7.0, 1.5, 0.0), (begin_s + 1.0, 7.5, 1.5, 0.0))
    there = ((1.0, 1.0, 1.5, 0.0), (5.0, 7.0, 1.5, 0.0))
    motions = [
        Motion(time_s=waypoints[0][0], robot=0, waypoints=waypoints, purpose="explore")
        for waypoints in (there, way)
    ]
    run = written(
        [*nodes, *motions],
        starts=((1.0, 1.5, 0.0),),
        environment=room,
        strategy=strategy,
        options=options,
        radio=RadioSpec(range_m=2.0),
        base=BaseSpec(x=1.0, y=1.0),
        stop=StopRule(max_time_s=41.0),
        end_s=41.0,
    )
    found = INVARIANTS["turns-back-in-time"](run)
    assert (found is not None) is finds
    assert found is None or found.says.startswith("robot 0 sets out to explore at 22.00 s, ")


def node_at(x, serial, time_s=0.0):
    corners = shapely.get_coordinates(shapely.box(x - 4.0, 0.0, x + 4.0, 3.0))[:4][::-1]
    return NodeAdded(
        time_s=time_s,
        robot=0,
        serial=serial,
        parent=None,
        configuration=(x, 1.5, 0.0),
        stage="scan",
        boundary=tuple(map(tuple, corners.clip(0.0, 12.0).tolist())),
        tags="0101",
    )


def test_stretches_are_whole_in_collections_too():
    lines = [shapely.LineString([(0, 0), (1, 0)]), shapely.LineString([(1, 0), (2, 0)])]
    mixed = shapely.GeometryCollection([*lines, shapely.Point(5, 5), shapely.LineString()])
    assert [stretch.length for stretch in stretches(mixed)] == [2.0]
    assert [stretch.length for stretch in stretches(shapely.LineString())] == []


@pytest.mark.parametrize(
    ("reason", "stops", "stays", "strategy", "is_found"),
    [
        ("boxed in by robot 1, which does not give way", 5, 0, "srt-star", True),
        ("boxed in by robot 1, which does not give way", 8, 0, "srt-star", False),
        ("boxed in by robot 1, which does not give way", 0, 5, "srt-star", True),
        ("boxed in by robot 1, which does not give way", 2, 6, "srt-star", False),
        ("boxed in by robot 1, which does not give way", 5, 0, "minpos", False),
        (
            "boxed in at the start, where the scan shows no way for the body",
            0,
            0,
            "srt-star",
            False,
        ),
        ("every frontier arc is explored or closed", 0, 0, "srt-star", False),
    ],
)
def test_a_robot_is_boxed_in_after_its_attempts(reason, stops, stays, strategy, is_found):
    at = (0.5, 0.5, 0.0)
    stopped = [Blocked(time_s=1.0 + k, robot=0, by=1, configuration=at) for k in range(stops)]
    stayed = [
        Decision(time_s=2.0 + k, robot=0, node=(0, 0), frontier_m=1.0, choice="stay", target=None)
        for k in range(stays)
    ]
    of_another = [Blocked(time_s=3.0, robot=1, by=0, configuration=at) for _ in range(50)]
    late = [Blocked(time_s=18.5, robot=0, by=1, configuration=at) for _ in range(50)]
    end = Ended(time_s=18.0, robot=0, reason=reason, complete=False, frontier=())
    run = written(
        [*stopped, *stayed, *of_another, end, *late],
        starts=(at, (2.5, 0.5, 0.0)),
        strategy=strategy,
        options={"boxed_in_after": 8, "gives_up_after": 40} if strategy == "srt-star" else {},
    )
    found = says(run, "boxed-in-after-attempts")
    assert (f"after {stops} stops, 0 orders and {stays} choices to stay" in found) is is_found
    assert bool(found) is is_found


@pytest.mark.parametrize(
    ("count", "between", "is_found"),
    [
        (3, None, False),
        (4, None, True),
        (4, drive(0, (2.5, 0.5, 0.5, 0.0), (2.6, 0.6, 0.5, 0.0)), False),
        (4, Learned(time_s=2.5, robot=0, nodes=((1, 0),)), False),
        (4, Learned(time_s=2.5, robot=1, nodes=((0, 0),)), True),
    ],
)
def test_a_robot_waits_as_often_as_allowed(count, between, is_found):
    choices = [
        GoalChosen(time_s=1.0 + k, robot=0, rule="minpos", because="blocked", goal=None)
        for k in range(count)
    ]
    extra = [] if between is None else [between]
    for strategy in ("minpos", "srt-star"):
        run = written(
            [*choices, *extra],
            starts=((0.5, 0.5, 0.0), (2.5, 0.5, 0.0)),
            strategy=strategy,
            options={"max_waits": 2},
        )
        found = says(run, "waits-as-often-as-allowed")
        assert ("waits for others to leave 3 times in a row" in found) is (
            is_found and strategy == "minpos"
        )
