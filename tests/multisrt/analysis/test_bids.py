"""How goals were bid for, by the radius of cohesion."""

import multisrt as ms
from multisrt.analysis.bids import bids_by_radius
from multisrt.events import GoalChosen
from tests.multisrt.drawing.recordings import A, C, recorded


def chosen(robot, bids, costs, *, phi_m=(13.5,), goal=A, rule="self-bidding"):
    return GoalChosen(
        time_s=0.0,
        robot=robot,
        rule=rule,
        because="reached",
        goal=goal,
        frontiers=(A, C)[: len(bids[0])],
        robots=(0, 1),
        costs=costs,
        bids=bids,
        phi_m=phi_m,
    )


def test_goals_are_counted_by_the_radius_that_they_were_bid_for_with():
    near, two = ((1.0, 4.0), (3.0, 2.0)), ((-2.0, 2.0), (2.0, -2.0))
    # One frontier for two robots: that of the lower bid gets it, the other a virtual one.
    one, shared = ((1.0,), (3.0,)), ((-2.0,), (2.0,))
    # The radius grew to its end, and the path of robot 0 still lies in no circle.
    apart = ((None, None), (2.0, -2.0))
    recording = recorded(
        [A, C],
        [
            chosen(0, two, near),
            chosen(1, two, near),
            chosen(0, two, near, phi_m=(13.5, 21.0)),
            chosen(0, shared, one),
            chosen(1, shared, one, phi_m=(13.5, 21.0)),
            chosen(0, apart, near, phi_m=(13.5, 21.0, 28.5)),
            chosen(1, apart, near, phi_m=()),  # A radio that reaches everywhere.
            chosen(1, two, near, goal=None),
            chosen(1, two, near, rule="minpos"),
            chosen(1, two, near[:1]),
        ],
    )
    assert bids_by_radius(recording) == {
        "first radius": 4,
        "larger radius": 1,
        "virtual frontier": 2,
    }


def test_the_bids_of_a_run_are_a_metric():
    run = ms.explore(
        "apartment",
        strategy="self-bidding",
        robots=3,
        seed=1,
        radio_range_m=4.0,
        options={"drive": "path"},
    )
    counted = run.metrics.bids_by_radius
    goals = [event for event in run.recording.of(GoalChosen) if event.goal is not None]
    assert sum(counted.values()) == len(goals)
    assert {"first radius", "larger radius"} & counted.keys()
    assert ms.explore("open", strategy="closest", seed=1).metrics.bids_by_radius == {}
