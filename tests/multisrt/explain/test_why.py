import re
from collections.abc import Sequence

import pytest
import shapely

from multisrt.environments.environment import Environment
from multisrt.events import (
    AnyEvent,
    Blocked,
    CameBack,
    Coordinated,
    Decided,
    Decision,
    Died,
    Ended,
    FellSilent,
    GoalChosen,
    Learned,
    MapComplete,
    Motion,
    NodeAdded,
    Organized,
    PresumedLost,
    Sent,
    Supports,
)
from multisrt.explain.srt import explain, explain_all
from multisrt.explain.words import troubles
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recorder, Recording, header_of
from multisrt.simulation.worlds import inline
from multisrt.spec import RobotSpec, RunSpec

HALL = Environment("hall", shapely.box(0, 0, 10, 10))
STARTS = (1.0, 1.0, 0.0), (5.0, 1.0, 0.0), (9.0, 1.0, 1.5)


def node(time_s: float, robot: int, serial: int, parent, place, stage="draw") -> NodeAdded:
    return NodeAdded(
        time_s=time_s,
        robot=robot,
        serial=serial,
        parent=parent,
        configuration=(*place, 0.0),
        stage=stage,
        boundary=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)),
        tags="000",
    )


def moved(robot: int, start, end, purpose="explore") -> Motion:
    return Motion(
        time_s=start[0], robot=robot, waypoints=((*start, 0.0), (*end, 0.0)), purpose=purpose
    )


STORY: tuple[AnyEvent, ...] = (
    *(node(0.0, robot, 0, None, STARTS[robot][:2], "root") for robot in range(3)),
    Decision(
        time_s=0.0, robot=2, node=(2, 0), frontier_m=3.5, choice="draw", target=(9.0, 4.0), draws=1
    ),
    moved(2, (0.0, 9.0, 1.0), (6.0, 9.0, 4.0)),
    node(6.0, 2, 1, (2, 0), (9.0, 4.0)),
    Learned(time_s=5.0, robot=2, nodes=((0, 0),)),
    Learned(time_s=6.0, robot=2, nodes=((1, 0),)),
    # An arrangement of another group, before; it is not that of robot 2's decision.
    Organized(
        time_s=3.0,
        robot=1,
        feasible=(),
        unfeasible=(0, 1),
        before={0: (0.5, 0.5), 1: (0.6, 0.6)},
        after={0: (0.5, 0.5), 1: (0.6, 0.6)},
        orders={0: "keep", 1: "keep"},
        conflicts=((0, 1),),
    ),
    Decision(
        time_s=6.0,
        robot=2,
        node=(2, 1),
        frontier_m=2.25,
        choice="approach",
        target=(7.0, 6.0),
        draws=10,
        refused={"near a node": 7, "no room": 3},
        candidates=((9.1, 4.1, "near a node"), (9.9, 4.0, "no room")),
        gpr=(0, 1, 2),
        ger=(1, 2),
    ),
    Organized(
        time_s=6.0,
        robot=1,
        feasible=(),
        unfeasible=(1, 2),
        before={1: (8.0, 6.0), 2: (7.0, 6.0)},
        after={1: (8.0, 6.0), 2: (8.5, 7.0)},
        orders={1: "keep", 2: "new target"},
        conflicts=((1, 2),),
        deadlock=True,
    ),
    Coordinated(
        time_s=6.25,
        robot=2,
        ger=(1, 2),
        master=1,
        feasible=(),
        unfeasible=(1, 2),
        target=(7.0, 6.0),
        order="new target",
        new_target=(8.5, 7.0),
    ),
    moved(2, (6.25, 9.0, 4.0), (9.0, 8.75, 5.5)),
    Blocked(time_s=9.0, robot=2, by=0, configuration=(8.75, 5.5, 0.0)),
    PresumedLost(time_s=12.0, robot=2, other=1),
    FellSilent(time_s=13.0, robot=2),
    CameBack(time_s=14.0, robot=2),
    MapComplete(time_s=15.0, robot=2),
    Decision(time_s=15.0, robot=2, node=(2, 0), frontier_m=0.0, choice="end", target=None),
    Ended(time_s=15.0, robot=2, reason="nothing left", complete=True, frontier=()),
    Supports(
        time_s=16.0,
        robot=2,
        tree=1,
        open_frontier_m={0: 1.5, 1: 12.0, 2: 0.0},
        active_robots={0: 2, 1: 1},
        candidates=(1,),
    ),
    moved(2, (16.0, 9.0, 1.0), (20.0, 7.0, 1.0), "support"),
    Coordinated(
        time_s=20.5,
        robot=2,
        ger=(0, 2),
        master=2,
        feasible=(),
        unfeasible=(0, 2),
        target=(5.0, 1.0),
        order="wait",
        new_target=(7.0, 1.0),
    ),
    moved(2, (21.0, 7.0, 1.0), (24.0, 5.0, 1.0), "support"),
    Decision(
        time_s=24.0,
        robot=2,
        node=(1, 0),
        frontier_m=4.0,
        choice="draw",
        target=(5.0, 3.0),
        draws=2,
        refused={"blocked by a robot": 1},
        gpr=(1, 2),
        ger=(1, 2),
    ),
    moved(2, (24.0, 5.0, 1.0), (27.0, 5.0, 2.5)),
    Died(time_s=27.0, robot=2, configuration=(5.0, 2.5, 0.0), doing="moving"),
    Decision(time_s=28.0, robot=0, node=(0, 0), frontier_m=0.0, choice="end", target=None),
)


def recorder_of(events: Sequence[AnyEvent], strategy: str, **options: str) -> Recorder:
    """Return a recorder to which a team of three has told events."""
    spec = RunSpec(
        environment=inline(HALL),
        strategy=strategy,
        options={**options},
        robots=tuple(RobotSpec(start=start) for start in STARTS),
    )
    recorder = Recorder(header_of(spec, HALL, tuple(Configuration(*s) for s in STARTS)))
    for event in events:
        recorder.record(event)
    return recorder


@pytest.fixture(scope="module")
def recording() -> Recording:
    return recorder_of(STORY, "srt-radial").finish(30.0, "stalled", "")


def part(text: str, title: str) -> str:
    """Return the lines of a section, whose title may have a time after a comma."""
    found = re.search(rf"\n{re.escape(title)}(?:, .*)?\n((?:.+\n?)*)", text)
    return found[1].removesuffix("\n") if found else ""


def test_knowledge_and_decision_are_explained(recording):
    text = explain(recording, 2, 8.0)
    assert text.startswith("Robot 2 at 8.00 s: its last decision was at 6.00 s.\n")
    place = part(text, "Where it stood")
    assert "at node 1, (9.00, 4.00), which was added at 6.00 s" in place
    assert "its parent is node 0; the place was found by: random draw" in place
    knew = part(text, "What it knew")
    assert "local frontier there was 2.25 m long" in knew
    assert "its map had 2 nodes that it had made" in knew
    assert "learned 2 nodes of others: 1 of robot 0, 1 of robot 1; last at 6.00 s" in knew
    assert "complete" not in knew
    decided = part(text, "What it decided")
    assert "10 candidates drawn; refused: 7 near a node, 3 no room" in decided
    assert "(9.10, 4.10): near a node" in decided
    assert "(9.90, 4.00): no room" in decided
    assert "it chose approach: " in decided
    assert "target (7.00, 6.00), 2.83 m away" in decided


def test_arcs_are_listed_by_their_values():
    decision = Decision(
        time_s=0.0,
        robot=0,
        node=(0, 0),
        frontier_m=3.5,
        choice="gain",
        target=(4.0, 1.0),
        arcs=((5.0, 1.0, 25.04, 4.0, 0.08), (1.0, 4.0, 2.5, 3.5, 0.02)),
    )
    told = node(0.0, 0, 0, None, STARTS[0][:2], "root"), decision
    story = recorder_of(told, "srt-radial", choice="gain").finish(1.0, "stalled", "")
    decided = part(explain(story, 0, 0.0), "What it decided").splitlines()
    assert [line.split() for line in decided[1:4]] == [
        ["middle", "area", "way", "value"],
        ["(5.00,", "1.00)", "25.0", "m²", "4.00", "m", "100.0%"],
        ["(1.00,", "4.00)", "2.5", "m²", "3.50", "m", "25.0%"],
    ]
    assert (
        "it chose best arc: a place that sees the frontier arc of the highest value" in decided[4]
    )


def test_the_orders_of_the_master_are_explained(recording):
    group = part(explain(recording, 2, 8.0), "Its group")
    assert "pre-engaged (GPR): 0, 1, 2" in group
    assert "engaged (GER): 1, 2" in group
    assert "paths of the group 1, 2 conflicted; the master was robot 1" in group
    assert "feasible: none; unfeasible: 1, 2" in group
    assert "in conflict: 1 with 2" in group
    assert "a deadlock" in group
    assert re.search(r"\b1 +\(8\.00, 6\.00\) +\(8\.00, 6\.00\)  keep target\n", group)
    assert re.search(r"\b2 +\(7\.00, 6\.00\) +\(8\.50, 7\.00\)  new target\n", group)
    assert "at 6.25 s its order was to go to another target: (7.00, 6.00) became (8.50, 7.00)" in (
        group
    )
    assert "(0.50, 0.50)" not in group


def test_a_step_to_another_tree_is_coordinated_without_decision(recording):
    assert "master" not in explain(recording, 2, 20.0)
    group = part(explain(recording, 2, 22.0), "Its group")
    assert "paths of the group 0, 2 conflicted; the master was itself" in group
    assert "at 20.50 s its order was to wait where it stands" in group


def test_where_no_paths_conflicted(recording):
    group = part(explain(recording, 2, 25.0), "Its group")
    assert "no paths of the group conflicted" in group
    assert "master" not in group
    assert "Its group" not in explain(recording, 2, 3.0)


def test_motions_under_way_and_completed_are_told_apart(recording):
    then = "What it did next"
    assert "0.00 s: it set out to explore, and is on its way to (9.00, 4.00)" in part(
        explain(recording, 2, 3.0), then
    )
    assert "6.25 s: it set out to explore, and came to (8.75, 5.50)" in part(
        explain(recording, 2, 10.0), then
    )
    text = part(explain(recording, 2, 18.0), then)
    assert "15.00 s: it ended: nothing left" in text
    assert "16.00 s: it set out to support another tree, and is on its way to (7.00" in text


def test_the_supported_tree_is_explained(recording):
    assert "Which tree it supports" not in explain(recording, 2, 15.0)
    text = explain(recording, 2, 24.0)
    assert [line for line in text.splitlines() if re.match(r"\w", line)] == [
        "Robot 2 at 24.00 s: its last decision was at 24.00 s.",
        "Where it stood, at 24.00 s",
        "What it knew, at 24.00 s",
        "What it decided, at 24.00 s",
        "Its group, at 24.00 s",
        "Which tree it supports, since 16.00 s",
        "What did not go as planned",
        "What it did next, from 24.00 s",
    ]
    support = part(text, "Which tree it supports")
    assert "at 16.00 s: the tree of robot 1" in support
    assert re.search(r"\b0 +1\.50 m +2\n", support)
    assert re.search(r"\b1 +12\.00 m +1  may need support\n", support)
    assert re.search(r"\b2 +0\.00 m +0$", support)
    assert "at node 0 of robot 1" in explain(recording, 2, 24.0)


def test_events_that_were_not_planned_are_listed(recording):
    title = "What did not go as planned"
    assert title not in explain(recording, 2, 8.9)
    early = part(explain(recording, 2, 9.0), title)
    assert early == "  9.00 s: protective stop at (8.75, 5.50), before the body of robot 0"
    late = part(explain(recording, 2, 30.0), title)
    assert [line.split(" s: ")[0].strip() for line in late.splitlines()] == [
        "9.00",
        "12.00",
        "13.00",
        "14.00",
        "27.00",
    ]
    assert "no longer waits for robot 1, which does not answer" in late
    assert "died at (5.00, 2.50), moving" in late


def test_without_a_time_the_last_decision_is_explained(recording):
    assert explain(recording, 2) == explain(recording, 2, 30.0)
    assert "its last decision was at 24.00 s" in explain(recording, 2)
    assert "blocked by a robot" in explain(recording, 2)


def test_the_moment_of_a_decision_counts_as_after_it(recording):
    assert "its last decision was at 6.00 s" in explain(recording, 2, 6.0)
    assert "its last decision was at 0.00 s" in explain(recording, 2, 5.99)
    assert "since 15.00 s that its map was complete" in explain(recording, 2, 15.0)


def test_all_decisions(recording):
    head, *lines = explain_all(recording, 2).splitlines()
    assert head.split() == ["time", "(s)", "node", "frontier", "decision"]
    assert [line.split()[0] for line in lines] == ["0.00", "6.00", "15.00", "24.00"]
    assert lines[0].split() == ["0.00", "0", "3.50", "m", "random", "draw", "to", "(9.00,", "4.00)"]
    assert lines[1].endswith("approach to (7.00, 6.00), GER 1, 2; new target (8.50, 7.00)")
    assert lines[2].endswith("end")
    assert lines[3].split()[1] == "1:0"
    assert len(explain_all(recording, 1).splitlines()) == 1


@pytest.mark.parametrize(
    ("robot", "time_s", "said"),
    [
        (3, 1.0, "there is no robot 3: the team has 3 robots"),
        (-1, None, "there is no robot -1"),
        (2, 30.5, "30.5 s is not within the run, which lasts from 0 to 30.00 s"),
        (2, -0.1, "not within the run"),
        (2, float("nan"), "not within the run"),
        (0, 1.0, "robot 0 had not decided anything by 1 s; its first decision is at 28.00 s"),
        (1, None, "robot 1 put no decision on record in this run"),
    ],
)
def test_invalid_robots_and_times_are_refused(recording, robot, time_s, said):
    with pytest.raises(InvalidInputError) as error:
        explain(recording, robot, time_s)
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_decisions_of_a_robot_that_does_not_exist_are_refused(recording):
    with pytest.raises(InvalidInputError, match="there is no robot 3"):
        explain_all(recording, 3)


def chosen(time_s: float, robot: int, goal, rule="minpos", because="news", **known) -> GoalChosen:
    return GoalChosen(time_s=time_s, robot=robot, rule=rule, because=because, goal=goal, **known)


FAR_AND_NEAR = tuple((float(k), 9.0) for k in range(12))
TWO = ((3.0, 4.0), (7.5, 2.0))

BIDS: tuple[AnyEvent, ...] = (
    *(node(0.0, robot, 0, None, STARTS[robot][:2], "root") for robot in range(3)),
    chosen(0.0, 1, (7.5, 2.0), because="start"),
    moved(1, (0.0, 5.0, 1.0), (0.5, 5.25, 1.0)),
    node(0.5, 1, 1, (1, 0), (5.25, 1.0), "scan"),
    Learned(time_s=0.5, robot=1, nodes=((0, 0), (2, 0))),
    moved(1, (0.5, 5.25, 1.0), (1.0, 5.5, 1.0)),
    chosen(
        1.0,
        1,
        (3.0, 4.0),
        cost_m=3.25,
        frontiers=TWO,
        robots=(0, 1),
        costs=((None, 12.5), (3.25, 4.75)),
        ranks=((1, 1), (0, 0)),
    ),
    Sent(time_s=1.0, robot=1, kind="report", size_bytes=9),
    moved(1, (1.0, 5.5, 1.0), (1.5, 5.0, 1.0)),
    moved(1, (1.5, 5.0, 1.0), (2.0, 4.5, 1.0)),
    Blocked(time_s=2.0, robot=1, by=0, configuration=(4.5, 1.0, 0.0)),
    moved(1, (2.5, 4.5, 1.0), (3.5, 5.5, 1.0), "give way"),
    Learned(time_s=3.0, robot=1, nodes=((0, 1),)),
    chosen(
        4.0,
        1,
        (7.5, 2.0),
        rule="greedy",
        because="gave way",
        frontiers=TWO,
        robots=(0, 1),
        costs=((1.0, 2.0), (4.0, 2.25)),
        rounds=((0, 0, 1.0, 0.25), (1, 1, 1.0, 0.5625)),
    ),
    chosen(
        5.0,
        1,
        (7.5, 2.0),
        rule="self-bidding",
        because="stop signal",
        frontiers=TWO,
        robots=(0, 1),
        costs=((1.0, 2.0), (4.0, 2.25)),
        bids=((-3.0, None), (3.0, 0.25)),
        phi_m=(13.5, 21.0),
    ),
    chosen(
        6.0,
        1,
        (2.25, 2.75),
        rule="rules",
        because="no way",
        frontiers=TWO,
        robots=(1,),
        scores=((2.25, 2.75, 61.5, 12.0, 3.5, 7.0), (8.75, 0.25, 50.0, 20.0, 0.0, 0.0)),
    ),
    chosen(
        7.0,
        1,
        (0.0, 9.0),
        frontiers=FAR_AND_NEAR,
        robots=(0, 1, 2),
        costs=tuple(
            tuple(None if k == 3 and row != 1 else 100.0 - k for k in range(12)) for row in range(3)
        ),
        ranks=((10,) * 12, (0,) * 12, (11,) * 12),
    ),
    chosen(8.0, 1, None, because="nothing left"),
    Ended(time_s=8.0, robot=1, reason="no frontier is left", complete=True, frontier=()),
)


@pytest.fixture(scope="module")
def bidding() -> Recording:
    return recorder_of(BIDS, "minpos").finish(9.0, "complete", "")


def test_knowledge_and_reason_of_a_bidder_are_explained(bidding):
    text = explain(bidding, 1, 1.2)
    assert text.startswith("Robot 1 at 1.20 s: it last chose a goal at 1.00 s.\n")
    assert "at (5.50, 1.00)" in part(text, "Where it stood")
    knew = part(text, "What it knew")
    assert "its map had 2 scans of its own" in knew
    assert "learned 2 scans of others: 1 of robot 0, 1 of robot 2; last at 0.50 s" in knew
    assert "considered robot 0; not robot 2, idle" in knew
    why = part(text, "Why it chose again")
    assert "news: its map had changed" in why
    assert "before, since 0.00 s, its goal was (7.50, 2.00)" in why
    assert "frontier 0, (3.00, 4.00), 3.25 m away" in part(text, "What it chose")


def test_the_bid_table_marks_row_and_column_and_has_ranks(bidding):
    table = part(explain(bidding, 1, 1.2), "How it chose: minpos")
    assert re.search(r"frontier +0\* +1\n", table)
    assert re.search(r"x \(m\) +3\.00 +7\.50\n +y \(m\) +4\.00 +2\.00\n", table)
    assert re.search(r"\n    robot 0 +- \(1\) +12\.50 \(1\)\n", table)
    assert re.search(r"\n  > robot 1 +3\.25 \(0\) +4\.75 \(0\)", table)
    assert "not shown" not in table


def test_equal_troubles_in_a_row_have_one_line():
    stops = [
        Blocked(time_s=at, robot=0, by=by, configuration=(1.0, 2.0, 0.0))
        for at, by in ((1.0, 1), (2.0, 1), (3.5, 1), (4.0, 2), (5.0, 1))
    ]
    ended = Ended(time_s=3.0, robot=0, reason="told", complete=True, frontier=())
    assert list(troubles([*stops[:2], ended, *stops[2:]])) == [
        "1.00 to 3.50 s, 3 times: protective stop at (1.00, 2.00), before the body of robot 1",
        "4.00 s: protective stop at (1.00, 2.00), before the body of robot 2",
        "5.00 s: protective stop at (1.00, 2.00), before the body of robot 1",
    ]


def test_motions_of_a_bidder_until_its_next_choice_are_listed(bidding):
    text = explain(bidding, 1, 1.2)
    then = part(text, "What it did next").splitlines()
    assert then == [
        "  from 1.00 s on it drove 1.00 m in 1.00 s, to (4.50, 1.00)",
        "  from 2.50 s on it gave way and drove 1.00 m in 1.00 s, to (5.50, 1.00)",
        "  at 4.00 s it chose again: it had given way to another robot",
    ]
    told = part(text, "Messages until the next choice")
    assert "it sent 1 message: 1 report" in told
    assert "it learned 1 scan of others: 1 of robot 0" in told
    otherwise = "What did not go as planned"
    assert otherwise not in text
    assert "protective stop at (4.50, 1.00)" in part(explain(bidding, 1, 2.0), otherwise)


def test_rounds_bids_and_scores_are_shown(bidding):
    rounds = part(explain(bidding, 1, 4.0), "How it chose: greedy")
    assert "round  1:   robot 0 got frontier 0, (3.00, 4.00): 0.25 of the longest path" in rounds
    assert "round  2: > robot 1 got frontier 1, (7.50, 2.00): 0.56 of the longest path" in rounds
    bids = part(explain(bidding, 1, 5.0), "How it chose: self-bidding")
    assert "(phi): 13.5, 21.0 m" in bids
    assert re.search(r"bids that were matched.*\n    robot 0 +-3\.00 +-\n  > robot 1 +3\.00", bids)
    scores = part(explain(bidding, 1, 6.0), "How it chose: rules")
    assert re.search(r"\* +\(2\.25, 2\.75\) +61\.50 +12\.00 +3\.50 +7\.00", scores)
    assert re.search(r"\n    +\(8\.75, 0\.25\) +50\.00", scores)


def test_only_the_nearest_and_the_chosen_frontiers_are_shown(bidding):
    table = part(explain(bidding, 1, 7.0), "How it chose: minpos")
    assert "6 of 12 frontiers are not shown" in table
    head = re.search(r"\n  frontier +(.*)", table)
    assert head is not None
    assert head[1].split() == ["0*", "7", "8", "9", "10", "11"]
    assert max(map(len, explain(bidding, 1, 7.0).splitlines())) <= 80


def test_no_goal_and_the_end(bidding):
    text = explain(bidding, 1)
    assert "no goal: there is none that it can reach" in part(text, "What it chose")
    assert "8.00 s: it ended: no frontier is left" in part(text, "What it did next")


@pytest.mark.parametrize(
    ("home", "said"),
    [
        ("never", "that it can reach"),
        ("in-time", "that it can reach and come home from in time"),
        ("chain", "that it can reach and from which the chain reaches the base station"),
    ],
)
def test_no_goal_is_explained_by_what_is_asked_of_goals(home, said):
    # Where there is no frontier at all, nothing else was asked.
    for frontiers, why in ((TWO, said), ((), "that it can reach")):
        choice = chosen(8.0, 1, None, because="nothing left", frontiers=frontiers)
        recorder = recorder_of([*BIDS[:-2], choice, BIDS[-1]], "minpos", home=home)
        lines = part(explain(recorder.finish(9.0, "complete", ""), 1), "What it chose")
        assert lines.splitlines()[0].strip() == f"no goal: there is none {why}"


@pytest.mark.parametrize(
    ("home", "said"),
    [
        ("never", None),
        ("in-time", "there is no time to go there and home"),
        ("chain", "the chain does not reach the base station from there"),
    ],
)
def test_what_a_missing_length_may_mean_is_told(home, said):
    recording = recorder_of(BIDS, "minpos", home=home).finish(9.0, "complete", "")
    table = part(explain(recording, 1, 7.0), "How it chose: minpos").splitlines()
    told = [line.strip() for line in table if "left out" in line]
    assert told == (
        [] if said is None else [f"a frontier with a length may be left out, too: {said}"]
    )


def test_the_errand_that_was_a_reason_is_named():
    told = (
        chosen(8.5, 1, None, because="errand"),
        Decided(time_s=8.6, robot=1, text="goes home: there is no time"),
        chosen(8.7, 1, None, because="errand over"),
    )
    recording = recorder_of((*BIDS[:-1], *told), "minpos").finish(9.0, "complete", "")
    before, after = (part(explain(recording, 1, t), "Why it chose again") for t in (8.55, 8.8))
    assert before.splitlines()[0].strip() == "errand: it had an errand"
    assert "the errand, from" not in before
    assert "the errand, from 8.60 s on: goes home: there is no time" in after


def test_all_choices_of_goals(bidding):
    head, *lines = explain_all(bidding, 1).splitlines()
    assert head.split() == ["time", "(s)", "frontiers", "path", "decision"]
    assert [line.split()[0] for line in lines] == [f"{t}.00" for t in (0, 1, 4, 5, 6, 7, 8)]
    assert lines[1].split(maxsplit=4) == [
        "1.00",
        "2",
        "3.25",
        "m",
        "minpos to (3.00, 4.00): its map had changed",
    ]
    assert lines[-1].endswith("minpos no goal: nothing was left to be seen at its last goal")
