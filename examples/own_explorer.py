"""A new explorer, alone and in teams: every robot drives to its nearest frontier.

`python examples/own_explorer.py` checks it, explores an environment and writes a picture.
"""

from pathlib import Path

import multisrt as ms
from multisrt.events import Learned
from multisrt.robots.explorer import Done, Look, Move, Note, Receive, Received, Send, Sense
from multisrt.robots.knowledge import Node
from multisrt.robots.toolkit import FrontierMap, Message, decided, trajectory_inside
from multisrt.testing import check_explorer


class News(Message, frozen=True):
    """The map of a robot."""

    node: Node


class NearestFrontier:
    """Drives to the nearest frontier, one second at a time, and sends what it sees."""

    def __init__(self, me):
        self.me, self.at, self.map = me, me.start, FrontierMap(me)

    def run(self):
        """Look, choose, and drive on until no frontier is left, or others block all paths."""
        waits = 0
        while waits < 100:
            yield from self.look((yield Sense()))
            frontiers = self.map.frontiers(self.at)
            if not frontiers:
                yield from self.hear(
                    (yield Done(complete=True, reason="no frontier is left", on_call=True))
                )
                continue
            with self.map.around((yield Look())):
                costs = self.map.costs(self.at, frontiers)
                goal = frontiers[costs.argmin()]
                path = self.map.path(self.at, goal)
            moved = None
            if path is not None:
                yield decided(self.me, self.time_s, "the nearest", goal, frontiers, path_m=costs)
                motion = trajectory_inside(self.me, self.at, path, self.map.region)
                if motion is None:
                    self.map.give_up(goal)
                    continue
                moved = yield Move(trajectory=motion.until(1.0), guard_m=0.1)
                self.at = moved.configuration
            is_barred = moved is None or moved.blocked_by is not None
            waits = waits + 1 if is_barred else 0
            yield from self.hear((yield Receive(self.me.rng.uniform(1.0, 3.0) * is_barred)))
        yield Done(complete=False, reason="other robots block all paths")

    def look(self, scan):
        """Add a scan to the map, and inform the others if it shows something new."""
        self.time_s = scan.time_s
        node = self.map.add(scan)
        if node is not None:
            yield Note(node.added("root" if node.parent is None else "scan"))
            yield Send(News(node=node, sender=self.me.robot))

    def hear(self, told):
        """Add to the map what others have seen."""
        new = self.map.merge(m.node for m in told.messages) if isinstance(told, Received) else ()
        if new:
            yield Note(Learned(time_s=told.time_s, robot=self.me.robot, nodes=new))


NEAREST_FRONTIER = ms.Strategy.of(NearestFrontier)


def main(environment="apartment", folder="out/examples"):
    """Check the explorer, explore an environment with a team of three and draw its paths."""
    print(check_explorer(NEAREST_FRONTIER))
    run = ms.explore(environment, strategy=NEAREST_FRONTIER, robots=3, seed=1)
    picture = Path(folder) / "own_explorer.svg"
    picture.parent.mkdir(parents=True, exist_ok=True)
    run.save_svg(picture)
    print(run)
    print(run.why(robot=1, time_s=20.0))
    print(f"The picture: {picture}")


if __name__ == "__main__":
    main()
