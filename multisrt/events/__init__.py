"""Events: what happens in a run, as plain data.

They are the lines of a recording, and `docs/recording.md` describes them as such: the names of
fields here are those in the file. Lengths are in metres, times in seconds from the start of the
run, angles in radians counter-clockwise from +x, positions in the frame of the environment. Robots
count from 0.

Examples
--------
>>> from multisrt import CatalogEnvironment, RunSpec, simulate
>>> from multisrt.events import Motion, NodeAdded
>>> recording = simulate(RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1))
>>> nodes = recording.of(NodeAdded)
>>> nodes[0].stage, nodes[0].parent
('root', None)
>>> recording.of(Motion)[0].robot
0
"""

from multisrt.events.coordination import Coordinated, Organized, Supports
from multisrt.events.decisions import (
    MAX_NAME_LENGTH,
    MAX_OPTIONS,
    MAX_TEXT_LENGTH,
    MAX_VALUES,
    Choice,
    Decided,
    Decision,
    DiagramEnd,
    DiagramLeft,
    GoalChosen,
)
from multisrt.events.event import Event, NodeName, Point, Pose, Segment
from multisrt.events.knowledge import (
    BLOCKED,
    ArcClosed,
    ArcReason,
    ArcReopened,
    ClosingReason,
    Learned,
    MapComplete,
    NodeAdded,
    PresumedLost,
    Stage,
)
from multisrt.events.simulated import (
    BaseLearned,
    Blocked,
    CameBack,
    Collision,
    Died,
    Ended,
    FellSilent,
    Joined,
    Motion,
    Purpose,
    Sensed,
    Sent,
)

__all__ = [
    "BLOCKED",
    "MAX_NAME_LENGTH",
    "MAX_OPTIONS",
    "MAX_TEXT_LENGTH",
    "MAX_VALUES",
    "AnyEvent",
    "ArcClosed",
    "ArcReason",
    "ArcReopened",
    "BaseLearned",
    "Blocked",
    "CameBack",
    "Choice",
    "ClosingReason",
    "Collision",
    "Coordinated",
    "Decided",
    "Decision",
    "DiagramEnd",
    "DiagramLeft",
    "Died",
    "Ended",
    "Event",
    "FellSilent",
    "GoalChosen",
    "Joined",
    "Learned",
    "MapComplete",
    "Motion",
    "NodeAdded",
    "NodeName",
    "NotedEvent",
    "Organized",
    "Point",
    "Pose",
    "PresumedLost",
    "Purpose",
    "Segment",
    "Sensed",
    "Sent",
    "Stage",
    "Supports",
]

NotedEvent = (
    NodeAdded
    | Decision
    | GoalChosen
    | DiagramLeft
    | Decided
    | Coordinated
    | Organized
    | Supports
    | ArcClosed
    | ArcReopened
    | MapComplete
    | Learned
    | PresumedLost
)
"""Events that explorers put on record. All others are recorded by the simulation: they say what
robots did, not what they say of it."""

AnyEvent = (
    NotedEvent
    | Motion
    | Sensed
    | Sent
    | BaseLearned
    | Blocked
    | Died
    | FellSilent
    | CameBack
    | Joined
    | Collision
    | Ended
)
