"""One mission of a team whose goals come from outside."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from multisrt.analysis.explorable import explorable, viewers
from multisrt.environments.environment import Environment
from multisrt.envs.rewards import Gain
from multisrt.envs.seen import SeenArea
from multisrt.events import AnyEvent, Died, Motion
from multisrt.finished_run import Run
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import ExactScan, LaserScan, Scan
from multisrt.planners.motion.trajectory import leg_length
from multisrt.robots.policy import Answer, DecisionSpec, Observation, PolicyExplorer
from multisrt.robots.policy.observing import nothing_observed, on_the_way
from multisrt.robots.policy.strategy import policy_strategy
from multisrt.robots.registry import registered
from multisrt.simulation.stepping import Stepping
from multisrt.spec import RunSpec

STRATEGY = "policy"
"""The name of the strategy in the specs and recordings of missions."""

COVERED = "covered"
"""The outcome of a mission that is over as the team has seen enough."""

End = Literal["terminated", "truncated"]
"""How a mission ended: it was over, or the stop rule cut it off."""


class Mission:
    """One mission, which pauses whenever a robot asks where to go.

    Parameters
    ----------
    spec : RunSpec
        The run; its strategy is `STRATEGY`.
    world : Environment
        Its world.
    decision : DecisionSpec
        What robots observe and may be answered.
    end_coverage : float or None
        Share of what the team can explore at which the mission is over, once a robot asks; None:
        it goes on until the robots are done.

    Attributes
    ----------
    asking : int or None
        The robot that asks; None once the mission is over.
    end : {"terminated", "truncated"} or None
        How it ended; None while it goes on.
    dead : set of int
        Robots that have died.
    regions : list of (n, 2) array
        What each scan showed so far, in metres.
    """

    def __init__(
        self,
        spec: RunSpec,
        world: Environment,
        decision: DecisionSpec,
        end_coverage: float | None,
    ) -> None:
        with registered(policy_strategy(STRATEGY, None, decision)):
            self._steps = Stepping(spec, world, watch=self._note)
        self._decision = decision
        self._team = len(spec.robots)
        starts = [state.configuration for state in self._steps.robots]
        self._seen = SeenArea(world, starts[0])
        self._goal_m2: float | None = None
        if end_coverage is not None:
            what = explorable(world, viewers(self._steps.spec, starts))
            self._goal_m2 = end_coverage * what.area_m2
        self.asking: int | None = None
        self.end: End | None = None
        self._ended = ("", "")
        self._is_closed = False
        self.dead: set[int] = set()
        self.regions: list[FloatArray] = []
        self._seen_by: list[int] = []
        self._measured = 0
        self._driven_m = np.zeros(self._team)
        self._since_s = 0.0
        self._observed = [nothing_observed(self._team, decision) for _ in range(self._team)]
        self._advance()
        self._collect()

    # What is observed -----------------------------------------------------------------------

    @property
    def time_s(self) -> float:
        """The time of the run in seconds."""
        return self._steps.time_s

    @property
    def seen_m2(self) -> float:
        """The area that the team has seen, in square metres."""
        return self._seen.area_m2

    def observation(self, robot: int) -> Observation:
        """Return what a robot observes, as new arrays.

        A robot that is on its way, or done, has the observation of its last question.
        """
        if robot == self.asking:
            self._observed[robot] = self._explorer(robot).observe()
            return {name: part.copy() for name, part in self._observed[robot].items()}
        return on_the_way(self._observed[robot], self._decision)

    def info(self, robot: int) -> dict[str, Any]:
        """Return the info dict that accompanies an observation."""
        told: dict[str, Any] = {
            "decides": robot == self.asking,
            "valid": self._explorer(robot).pending.was_valid,
            "time_s": self.time_s,
            "seen_m2": self.seen_m2,
        }
        if self.end is not None:
            told["outcome"], told["reason"] = self._ended
        return told

    @property
    def world(self) -> Environment:
        """The world."""
        return self._steps.environment

    @property
    def places(self) -> FloatArray:
        """The true places of the robots, ``(robots, 2)`` metres."""
        return np.array([state.configuration[:2] for state in self._steps.robots])

    @property
    def run(self) -> Run:
        """The run so far; once the mission is over, the whole run."""
        return Run(self._steps.recording, self.world)

    # How it goes on -------------------------------------------------------------------------

    def step(self, answer: Answer) -> list[Gain]:
        """Answer the robot that asks, and go on until one asks again or the mission is over.

        Returns
        -------
        list of Gain
            What that brought each robot.

        Raises
        ------
        InvalidInputError
            If the answer is none, and nothing has changed; or if the mission is over and that
            was told already.
        """
        if self._is_closed:
            raise InvalidInputError("the mission is over: call reset first")
        if self.asking is not None:
            self._explorer(self.asking).pending.answer = self._decision.checked(answer)
            self._advance()
        gains = self._collect()
        # A mission that is over as it begins has one step, which tells so.
        self._is_closed = self.end is not None
        return gains

    def close(self) -> None:
        """End the mission where it is."""
        self._is_closed = True
        self._steps.close()

    def _explorer(self, robot: int) -> PolicyExplorer:
        explorer = self._steps.explorers[robot]
        assert isinstance(explorer, PolicyExplorer)
        return explorer

    def _advance(self) -> None:
        self.asking = None
        explorers = [self._explorer(robot) for robot in range(self._team)]
        for step in self._steps:
            if isinstance(step.outcome, ExactScan | LaserScan):
                self.regions.append(_shown(step.outcome))
                self._seen_by.append(step.robot)
            if explorers[step.robot].pending.question is not None:
                self.asking = step.robot
                return
        footer = self._steps.recording.footer
        self.end = "truncated" if footer.outcome == "out_of_time" else "terminated"
        self._ended = footer.outcome, footer.reason

    def _collect(self) -> list[Gain]:
        new_m2 = self._seen.add(self.regions[self._measured :])
        own_m2 = np.zeros(self._team)
        np.add.at(own_m2, np.array(self._seen_by[self._measured :], np.int64), new_m2)
        self._measured = len(self.regions)
        if self.end is None and self._goal_m2 is not None and self.seen_m2 >= self._goal_m2:
            self.asking, self.end = None, "terminated"
            self._ended = COVERED, f"the team has seen {self.seen_m2:.1f} m2"
            self._steps.close()
        took_s, self._since_s = self.time_s - self._since_s, self.time_s
        driven_m, self._driven_m = self._driven_m, np.zeros(self._team)
        return [
            Gain(
                robot=robot,
                team_m2=float(new_m2.sum()),
                own_m2=float(own_m2[robot]),
                time_s=took_s,
                distance_m=float(driven_m[robot]),
            )
            for robot in range(self._team)
        ]

    def _note(self, event: AnyEvent) -> None:
        if isinstance(event, Motion):
            legs = zip(event.waypoints, event.waypoints[1:], strict=False)
            self._driven_m[event.robot] += sum(leg_length(a, b) for a, b in legs)
        elif isinstance(event, Died):
            self.dead.add(event.robot)


def _shown(scan: Scan) -> FloatArray:
    # As `multisrt.analysis.scans` judges them.
    if isinstance(scan, ExactScan):
        return scan.boundary
    return local_safe_region(scan, "radial").boundary
