"""One robot's knowledge of the others of its team."""

from __future__ import annotations

import math
from collections.abc import Iterable

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.robots.explorer import RobotSelf, Sighting
from multisrt.robots.listening import question_period_s
from multisrt.robots.multi_srt.messages import RobotState
from multisrt.robots.multi_srt.obstacles import UNMOVED_M, Obstacles
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.multi_srt.whereabouts import Whereabouts

ALMOST_NEVER = 1e-4
"""A robot is presumed lost when its silence by message loss alone is at most this probable."""


class Roster:
    """The last known state of every other robot, and which of them answer.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    options : MultiSrtOptions
        Its parameters.
    at : Whereabouts
        Where it is, and at what time.
    obstacles : Obstacles
        Bodies that it plans around; those that are heard from are removed.

    Attributes
    ----------
    states : dict of int to RobotState
        The newest state that was heard from every robot.
    heard_s : dict of int to float
        When a robot was last heard from.
    lost : dict of int to None
        Robots that are presumed lost, in this order.
    left_out_until_s : dict of int to float
        Until when a robot is left out of the own groups.
    patience : int
        Number of questions without an answer after which a robot is presumed lost.
    """

    def __init__(
        self, me: RobotSelf, options: MultiSrtOptions, at: Whereabouts, obstacles: Obstacles
    ) -> None:
        self.states: dict[int, RobotState] = {}
        self.heard_s: dict[int, float] = {}
        self.lost: dict[int, None] = {}
        self.left_out_until_s: dict[int, float] = {}
        self._unanswered: dict[int, int] = {}
        self._spoke_s: dict[int, float] = {}
        self._footprints = {str(me.footprint): me.footprint}
        self._own = me.robot
        self._at = at
        self._obstacles = obstacles
        self._period_s = question_period_s(me.radio, options.ask_period_s)
        if options.silence_timeout_s is not None:
            self.patience = math.ceil(options.silence_timeout_s / self._period_s)
        else:
            unheard = 1.0 - (1.0 - me.radio.loss) ** 2
            self.patience = (
                math.ceil(math.log(ALMOST_NEVER) / math.log(unheard)) if unheard > 0.0 else 1
            )

    def footprint(self, number: int) -> Footprint:
        """Return the footprint of another robot."""
        text = self.states[number].footprint
        if text not in self._footprints:
            self._footprints[text] = Footprint.parse(text)
        return self._footprints[text]

    def sighting(self, number: int) -> Sighting:
        """Return the body of another robot where it said that it is."""
        return Sighting(
            robot=number,
            configuration=Configuration(*self.states[number].place),
            footprint=self.footprint(number),
        )

    def present(self) -> dict[int, RobotState]:
        """Return the states of the robots that may belong to a group."""
        present = self.states.copy()
        for number in (*self.lost, *self.left_out_until_s):
            if self.is_out(number):
                present.pop(number, None)
        return present

    def is_out(self, number: int) -> bool:
        """Whether a robot belongs to no group: it is presumed lost, or left out for a while."""
        return number in self.lost or self.left_out_until_s.get(number, 0.0) > self._at.time_s

    def answers(self, number: int) -> bool:
        """Whether a robot was heard from and is not presumed lost."""
        return number in self.states and number not in self.lost

    def responds(self, number: int) -> bool:
        """Whether a robot answers and belongs to groups, so that it can be asked to give way."""
        return self.answers(number) and not self.is_out(number)

    def is_news(self, sighting: Sighting) -> bool:
        """Whether a robot that answers is seen elsewhere than where it said that it stands."""
        if not self.answers(sighting.robot):
            return False
        state = self.states[sighting.robot]
        if state.phase == "moving":
            return False
        return math.dist(state.place[:2], sighting.configuration[:2]) > UNMOVED_M

    def is_any_moving(self, numbers: Iterable[int]) -> bool:
        """Whether any of some other robots is moving."""
        return any(self.states[number].phase == "moving" for number in numbers)

    def take(self, state: RobotState, sender: int) -> None:
        """Keep a state that a robot has reported, of itself or of another, if it is newer."""
        number = state.robot
        if number == self._own:
            return
        if number == sender:
            self._spoke_s[number] = self._at.time_s
        known = self.states.get(number)
        if known is None or state.said >= known.said:
            self.states[number] = state
            self.hear_from(number)
            if state.phase == "moving":
                self._obstacles.avoided.pop(number, None)

    def hear_from(self, number: int) -> None:
        """Note that a robot answers."""
        self.heard_s[number] = self._at.time_s
        self.lost.pop(number, None)
        self._unanswered[number] = 0
        self._obstacles.silent.pop(number, None)

    def is_to_answer(self, number: int) -> bool:
        """Whether a robot has been asked since it was last heard from, or presumed lost."""
        return self._unanswered.get(number, 0) > 0

    def is_lost_when_asked(self, number: int) -> bool:
        """Count a question to a robot; return whether it is presumed lost now."""
        self._unanswered[number] = self._unanswered.get(number, 0) + 1
        if self._unanswered[number] <= self.patience:
            return False
        self._unanswered[number] = 0
        self.lost[number] = None
        return True

    def vouched(self, numbers: Iterable[int]) -> tuple[RobotState, ...]:
        """Return the states of those of some robots that were heard themselves lately.

        States known only at second hand are not passed on: dead robots would seem alive.
        """
        lately = self._at.time_s - self.patience * self._period_s
        return tuple(
            self.states[n]
            for n in numbers
            if n not in self.lost and self._spoke_s.get(n, -math.inf) >= lately
        )
