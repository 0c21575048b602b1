"""A recording of three robots in a hall in which everything happens that a replay shows."""

from multisrt.events import (
    ArcClosed,
    Blocked,
    Coordinated,
    Decision,
    Died,
    Learned,
    Organized,
    Sensed,
    Sent,
)
from multisrt.recording import Recording
from multisrt.spec import RadioSpec
from tests.multisrt.drawing.recordings import motion, node, recorded

STARTS = ((2.0, 4.0), (6.0, 4.0), (17.0, 4.0))
SECOND = (4.0, 5.0)  # node of robot 0
OTHER = (9.0, 6.0)  # node of robot 1
SHOWN_S = {
    "truth": 0.0,
    "seen": 3.0,
    "regions": 3.0,
    "trees": 3.0,
    "bridges": 12.0,
    "paths": 1.5,
    "frontier": 3.0,
    "goals": 5.1,
    "bodies": 3.0,
    "groups": 5.1,
    "masters": 5.3,
    "links": 3.0,
    "messages": 6.1,
    "stops": 11.5,
}
"""A time at which each layer shows something."""


def staged() -> Recording:
    """Return the recording; it lasts 100 s."""
    scans = [Sensed(time_s=0.0, robot=r, configuration=(*p, 0.0)) for r, p in enumerate(STARTS)]
    roots = [node(0.0, robot, 0, place) for robot, place in enumerate(STARTS)]
    both = (0, 1)
    places = {0: (6.0, 2.0), 1: (9.0, 2.0)}
    organized = Organized(
        time_s=5.2,
        robot=1,
        feasible=(0,),
        unfeasible=(1,),
        before=places,
        after={0: (6.0, 2.0), 1: OTHER},
        orders={0: "keep", 1: "wait"},
        conflicts=((0, 1),),
    )
    told = [
        Coordinated(
            time_s=5.2,
            robot=robot,
            ger=both,
            master=1,
            feasible=(0,),
            unfeasible=(1,),
            target=places[robot],
            order="keep" if robot == 0 else "wait",
            new_target=places[0] if robot == 0 else OTHER,
        )
        for robot in both
    ]
    decisions = [
        Decision(
            time_s=5.0,
            robot=robot,
            node=(robot, 1),
            frontier_m=3.0,
            choice="draw",
            target=places[robot],
            draws=2,
            refused={"no room": 1},
            candidates=((1.0, 1.0, "no room"),),
            gpr=(0, 1, 2),
            ger=both,
        )
        for robot in both
    ]
    return recorded(
        STARTS,
        [
            *scans,
            *roots,
            motion(1.0, 0, STARTS[0], SECOND),
            motion(1.0, 1, STARTS[1], OTHER),
            Sensed(time_s=2.0, robot=0, configuration=(*SECOND, 0.0)),
            node(2.0, 0, 1, SECOND, (0, 0)),
            Sensed(time_s=2.0, robot=1, configuration=(*OTHER, 0.0)),
            node(2.0, 1, 1, OTHER, (1, 0), "approach"),
            *decisions,
            organized,
            *told,
            Sent(time_s=6.0, robot=0, kind="map", size_bytes=100, reached=(1,), lost=(2,)),
            Learned(time_s=6.0, robot=1, nodes=((0, 0), (0, 1))),
            motion(10.0, 0, SECOND, STARTS[1]),
            Blocked(time_s=11.0, robot=0, by=1, configuration=(*STARTS[1], 0.0)),
            ArcClosed(time_s=12.0, robot=0, node=(0, 1), reason="too narrow", arc=((4, 1, 5, 1),)),
            Died(time_s=20.0, robot=2, configuration=(*STARTS[2], 0.0), doing="waiting"),
        ],
        radio=RadioSpec(range_m=12.0),
    )
