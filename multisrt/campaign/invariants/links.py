"""Messages arrive at the robots that the radio reaches, and at no others."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.campaign.bodies import FloatArray
from multisrt.campaign.judged_run import ROUNDING_M, ROUNDING_S, JudgedRun, silences
from multisrt.campaign.violations import Violation
from multisrt.events import Sent

NAME: Final = "messages-over-links"
REACHES_ALL: Final = "reaches-all-in-reach"
LOSSES: Final = "losses-at-rate"

ODDS: Final = 1e9
"""Likelihood ratio above which the losses contradict the rate of the spec."""

TO_ALL: Final = ("no place", "inaccessible")
"""Kinds of messages that are always sent to all."""

Place = tuple[float, float]


def messages_over_links(run: JudgedRun) -> Violation | None:
    """Check that a message reaches only robots that the radio links, directly or by relays.

    The sender, the receiver and all relays are switched on, alive and not silent. Each link is no
    longer than the range, to 1e-6 m. If walls block, its line lies in free space enlarged by 1e-6
    m; if walls weaken, the range is reduced for each wall that the line crosses. Without relays
    the sender must have a link to the receiver. Messages are lost only if the radio has losses.

    Cost: negligible for radios that reach everywhere; otherwise one line for each pair of places.
    """
    return next(_Links(run).violations(NAME, _Links.wrong), None)


def reaches_all_in_reach(run: JudgedRun) -> Violation | None:
    """Check that a message to all reaches all robots certainly linked, directly or by relays.

    As for `messages_over_links`, with all tolerances reversed: links that are shorter than the
    range by 1e-6 m, whose lines keep 1e-6 m from walls or cross so few walls that the signal
    suffices, between robots that are switched on, alive and not silent. A message counts as one to
    all if it reaches several robots, or is of a kind that is never sent to a single one. A receiver
    to which it was lost counts as reached. A message that reaches no robot is a violation if all
    others are certainly in range.

    Cost: negligible for radios that reach everywhere; otherwise one line for each pair of places.
    """
    links = _Links(run, is_sure=True)
    return next(links.violations(REACHES_ALL, _Links.missed), None)


def losses_at_rate(run: JudgedRun) -> Violation | None:
    """Check that messages are lost at the rate of the radio.

    The losses are compared with the rate by a likelihood ratio: that of a uniform prior over all
    rates to that of the rate of the spec. If losses are independent at that rate, it exceeds 1e9 at
    any time of a run with probability at most 1e-9 (Ville's inequality).

    Cost: negligible.
    """
    loss, sent = run.recording.spec.radio.loss, run.recording.of(Sent)
    lost = sum(len(message.lost) for message in sent)
    came = sum(len(message.reached) for message in sent)
    if loss == 0.0 or lost + came == 0:
        return None
    mixed = math.lgamma(lost + 1) + math.lgamma(came + 1) - math.lgamma(lost + came + 2)
    if mixed - lost * math.log(loss) - came * math.log1p(-loss) <= math.log(ODDS):
        return None
    return Violation(
        invariant=LOSSES,
        says=f"{lost} of {lost + came} receptions are lost, by a radio that loses {loss:g} of them",
    )


class _Links:
    """The links of a run, computed independently: possible ones, or certain ones."""

    def __init__(self, run: JudgedRun, *, is_sure: bool = False) -> None:
        self._run = run
        self._slack = -1.0 if is_sure else 1.0
        self._radio = run.recording.spec.radio
        self._robots = len(run.robots)
        self._silences = [silences(run.recording.spec.faults, robot) for robot in run.robots]
        self._held: dict[tuple[Place, Place], bool] = {}
        self._places: dict[float, FloatArray] = {}

    def violations(
        self, name: str, wrong_with: Callable[[_Links, Sent], str | None]
    ) -> Iterator[Violation]:
        """Yield messages that arrived where they cannot, or did not arrive where they must."""
        sent = self._run.recording.of(Sent)
        self._place_all([message.time_s for message in sent])
        for message in sent:
            wrong = wrong_with(self, message)
            if wrong is not None:
                yield Violation(
                    invariant=name,
                    says=f"a message of {self._run.named(message.robot)} at {message.time_s:.2f} s "
                    f"({message.kind}) {wrong}",
                    robot=message.robot,
                    time_s=message.time_s,
                )

    def wrong(self, message: Sent) -> str | None:
        """Return what is wrong with a message that arrived where it cannot."""
        receivers, now_s = (*message.reached, *message.lost), message.time_s
        if not receivers:
            return None
        if message.lost and self._radio.loss == 0.0:
            return f"is lost to robot {message.lost[0]}, but this radio loses none"
        if not self._works(message.robot, now_s):
            return f"reaches robot {receivers[0]}, but its sender's radio does not work"
        for receiver in receivers:
            if receiver == message.robot:
                return "reaches its sender"
            if not self._works(receiver, now_s):
                return f"reaches robot {receiver}, whose radio does not work"
        if self._radio.reaches_everywhere:
            return None
        far = [n for n in receivers if not self._holds(message.robot, n, now_s)]
        if far and self._radio.multi_hop:
            reached = self._reached(message.robot, now_s)
            far = [n for n in far if n not in reached]
        if not far:
            return None
        places = self._places[now_s]
        apart_m = math.dist(places[message.robot], places[far[0]])
        return f"reaches robot {far[0]}, {apart_m:.3f} m away, to which there is no link"

    def missed(self, message: Sent) -> str | None:
        """Return what is wrong with a message that did not arrive where it must."""
        sender, now_s = message.robot, message.time_s
        receivers = {*message.reached, *message.lost}
        is_to_all = len(receivers) > 1 or message.kind in TO_ALL
        if (receivers and not is_to_all) or not self._works(sender, now_s):
            return None
        if self._radio.reaches_everywhere:
            in_reach = {n for n in self._members if self._works(n, now_s)} - {sender}
        elif self._radio.multi_hop:
            in_reach = self._reached(sender, now_s)
        else:
            others = [n for n in self._members if n != sender and self._works(n, now_s)]
            in_reach = {n for n in others if self._holds(sender, n, now_s)}
        missed = in_reach - receivers
        if is_to_all and missed:
            return f"does not reach {self._run.named(min(missed))}, which is in reach"
        if missed and len(missed) == len(self._members) - 1:
            return "reaches nobody, but all others are in reach"
        return None

    @property
    def _members(self) -> range:
        # All that take part in the radio traffic.
        return range(self._robots + (self._run.recording.spec.base is not None))

    def _works(self, member: int, time_s: float) -> bool:
        if member == self._robots:
            return True
        slack_s = self._slack * ROUNDING_S
        on_s, dead_s = self._run.present_s(member)
        if not on_s - slack_s <= time_s <= dead_s + slack_s:
            return False
        return not any(
            begin_s + slack_s < time_s < end_s - slack_s
            for begin_s, end_s in self._silences[member]
        )

    def _reached(self, sender: int, now_s: float) -> set[int]:
        """Return all that are connected to a sender."""
        waiting = {n for n in self._members if self._works(n, now_s)} - {sender}
        found, relays = set[int](), [sender]
        while relays:
            relay = relays.pop()
            heard = {n for n in waiting if self._holds(relay, n, now_s)}
            waiting -= heard
            found |= heard
            relays += sorted(heard)
        return found

    # Links of places ------------------------------------------------------------------------

    def _place_all(self, times_s: list[float]) -> None:
        if self._radio.reaches_everywhere:
            return
        times = np.unique(np.array(times_s))
        places = [track.at(times)[:, :2] for track in self._run.tracks]
        base = self._run.recording.spec.base
        if base is not None:
            places.append(np.tile(base.place, (len(times), 1)))
        self._places = dict(zip(times.tolist(), np.stack(places, axis=1), strict=True))

    def _holds(self, one: int, other: int, now_s: float) -> bool:
        places = self._places[now_s]
        ax, ay = places[min(one, other)].tolist()
        bx, by = places[max(one, other)].tolist()
        ends = (ax, ay), (bx, by)
        if ends not in self._held:
            self._held[ends] = self._may_hold(*ends)
        return self._held[ends]

    def _may_hold(self, here: Place, there: Place) -> bool:
        radio, apart_m, slack_m = self._radio, math.dist(here, there), self._slack * ROUNDING_M
        if apart_m > radio.reach_m + slack_m:
            return False
        if radio.walls == "pass":
            return True
        line, free = shapely.LineString([here, there]), self._free
        if shapely.covers(free, line):
            return True
        if radio.walls == "block":
            return False
        walls = len(shapely.get_parts(shapely.difference(line, free)))
        # 10 n log10(distance / range) + the loss of all walls <= 0.
        weaker = radio.wall_loss_db * walls / (10.0 * radio.path_loss_exponent)
        return bool(apart_m <= radio.reach_m * 10.0**-weaker + slack_m)

    @property
    def _free(self) -> BaseGeometry:
        walls = self._run.walls
        return walls.grown if self._slack > 0.0 else self._run.once("shrunk", walls.shrunk)
