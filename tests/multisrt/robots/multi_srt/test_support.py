from types import SimpleNamespace
from typing import Any

import pytest

from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt import support
from multisrt.robots.multi_srt.progress import BoxedIn
from multisrt.robots.multi_srt.support import entry, follow_orders, may_need_support

# From near to far: a node of the robot's own tree, and three of the tree that it supports.
OWN, EXPLORED, OPEN, ROOT = NodeId(1, 4), NodeId(0, 2), NodeId(0, 1), NodeId(0, 0)


def robot_with(option: str, *open_nodes: NodeId) -> Any:
    """Return a robot at a node of its own tree, with these nodes open."""

    def to_nearest(here: NodeId, wanted: Any) -> list[NodeId] | None:
        along = (OWN, EXPLORED, OPEN, ROOT)
        return next(([here, *along[: k + 1]] for k, n in enumerate(along) if wanted(n)), None)

    return SimpleNamespace(
        options=SimpleNamespace(entry=option),
        at=SimpleNamespace(node=NodeId(1, 0)),
        map=SimpleNamespace(tree=lambda node: NodeId(node.robot, 0)),
        deferred=SimpleNamespace(has_frontier=lambda node: node in open_nodes),
        routes=SimpleNamespace(to_nearest=to_nearest),
    )


@pytest.mark.parametrize(
    ("option", "open_nodes", "node"),
    [
        ("root", (OWN, OPEN), ROOT),
        ("nearest_open", (OWN, OPEN), OPEN),
        ("nearest_open", (OWN, ROOT), ROOT),
        # None can be reached: the root, to which there may be a detour.
        ("nearest_open", (OWN,), ROOT),
    ],
)
def test_support_begins_at_the_root_or_at_the_nearest_open_node(option, open_nodes, node):
    assert entry(robot_with(option, *open_nodes), ROOT) == node


def robot_that_heard(
    heard_s: dict[int, float], *, in_contact: bool = False, ended: bool = False
) -> Any:
    """Return a robot with a limited radio at 100 s; robots 0 and 2 work on the tree of robot 0.

    Robot 0 may have ended.
    """
    states = {number: SimpleNamespace(tree=ROOT, phase="moving") for number in (0, 2)}
    if ended:
        states[0] = SimpleNamespace(tree=None, phase="idle")
    return SimpleNamespace(
        options=SimpleNamespace(
            support_m=1.0,
            support_in_contact=in_contact,
            check_period_s=30.0,
            take_over_after_s=120.0,
        ),
        at=SimpleNamespace(time_s=100.0),
        has_unlimited_range=False,
        team=SimpleNamespace(
            roster=SimpleNamespace(
                lost=set(),
                heard_s=heard_s,
                states=states,
            )
        ),
    )


@pytest.mark.parametrize(
    ("heard_s", "in_contact", "needs"),
    [
        ({0: 95.0, 2: 80.0}, True, True),
        ({0: 95.0, 2: 80.0}, False, False),
        ({0: 95.0, 2: 60.0}, True, False),
        ({0: 95.0}, True, False),
        ({0: -30.0, 2: -21.0}, False, True),
    ],
)
def test_with_a_limited_radio_robots_in_contact_support_one_another_if_asked_to(
    heard_s, in_contact, needs
):
    robot = robot_that_heard(heard_s, in_contact=in_contact)
    assert may_need_support(robot, ROOT, open_m=2.0, active=2) is needs
    assert not may_need_support(robot, ROOT, open_m=1.9, active=2)


@pytest.mark.parametrize(
    ("heard_s", "ended", "needs"),
    [
        ({0: 60.0, 2: -30.0}, True, True),
        ({0: 60.0, 2: -30.0}, False, False),
        ({0: 80.0, 2: -30.0}, True, False),  # it may be at home for a moment
        ({0: 60.0, 2: 60.0}, True, False),
    ],
)
def test_the_tree_of_an_owner_that_has_ended_is_free(heard_s, ended, needs):
    robot = robot_that_heard(heard_s, ended=ended)
    assert may_need_support(robot, ROOT, open_m=2.0, active=0) is needs


def test_a_robot_that_is_boxed_in_while_it_gives_way_says_that_it_stands(monkeypatch):
    """A group would wait for ever for the end of a motion that it announced."""
    done = []

    def move_to(robot, step):
        done.append("moves")
        yield from ()
        raise BoxedIn

    def rest():
        done.append("rests")
        yield from ()

    order = SimpleNamespace(order="give way")
    robot: Any = SimpleNamespace(
        at=SimpleNamespace(here=None),
        journey=SimpleNamespace(step_by=lambda order, step: "aside", target="there"),
        team=SimpleNamespace(order_for_me=lambda: order, rest=rest),
        trees=SimpleNamespace(root=NodeId(0, 0)),
    )
    list(follow_orders(robot))
    assert done == []  # At no node, it takes no order.
    robot.at.here = NodeId(0, 0)
    monkeypatch.setattr(support, "move_to", lambda robot, step: leave(robot, move_to(robot, step)))
    list(follow_orders(robot))
    assert done == ["moves", "rests"]
    assert robot.journey.target is None


def leave(robot, steps):
    """Take steps from a node."""
    robot.at.here = None
    yield from steps


def test_a_robot_that_does_not_answer_is_soon_asked_again(monkeypatch):
    """With messages lost, it is presumed lost only after many questions."""
    at = SimpleNamespace(time_s=100.0)
    waits: list[float] = []
    asked: list[list[int]] = []

    def stand_by(robot, until_s):
        waits.append(until_s - at.time_s)
        at.time_s = until_s
        yield from ()

    def ask(pending):
        asked.append(list(pending))
        yield from ()

    roster = SimpleNamespace(
        lost={3: None}, heard_s={1: 99.0, 2: 120.0}, is_to_answer=lambda number: bool(asked)
    )
    robot: Any = SimpleNamespace(
        at=at,
        has_unlimited_range=True,
        options=SimpleNamespace(check_period_s=30.0),
        team=SimpleNamespace(others=[1, 2, 3], roster=roster, period_s=0.5, ask=ask),
    )
    monkeypatch.setattr(support, "stand_by", stand_by)
    for _ in range(3):
        list(support.wait_for_news(robot))
    assert waits == [30.0, 0.5, 0.5]
    assert asked == [[1], [1], [1]]
    roster.heard_s[1] = at.time_s + 1.0
    list(support.wait_for_news(robot))
    assert waits[3] == 30.0
    assert asked[3] == [2]
