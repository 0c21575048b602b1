"""Messages come only to robots that the radio reaches."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np
import shapely

from multisrt.campaign.bodies import FloatArray
from multisrt.campaign.judged_run import ROUNDING_M, JudgedRun
from multisrt.campaign.violations import Violation
from multisrt.events import Sent
from multisrt.spec import Silence

NAME: Final = "messages-over-links"

ROUNDING_S: Final = 1e-6
"""At the very moment at which a radio fails or works again, both are right, to this (s)."""

Place = tuple[float, float]


def messages_over_links(run: JudgedRun) -> Violation | None:
    """Check that a message reaches only robots to which the radio has a link, or relays.

    The sender, the receiver and all relays take part and are not silent. Each link is no longer
    than the range, to 1e-6 m; where walls block, the line lies in free space grown by 1e-6 m, and
    where they weaken, the range is that for the number of its parts that do not. Without relays
    the one link is that of sender and receiver. Messages are lost only by a radio that loses some.

    Cost: negligible for radios that reach everywhere; else one line for each pair of places.
    """
    return next(_Links(run).violations(), None)


class _Links:
    """The links of a run, worked out anew."""

    def __init__(self, run: JudgedRun) -> None:
        self._run = run
        self._radio = run.recording.spec.radio
        self._robots = len(run.robots)
        self._silences = [f for f in run.recording.spec.faults if isinstance(f, Silence)]
        self._held: dict[tuple[Place, Place], bool] = {}
        self._places: dict[float, FloatArray] = {}

    def violations(self) -> Iterator[Violation]:
        """Yield messages that cannot have come where they are said to have come."""
        sent = self._run.recording.of(Sent)
        self._place_all([message.time_s for message in sent])
        for message in sent:
            wrong = self._wrong(message)
            if wrong is not None:
                sender = (
                    "the base station"
                    if message.robot == self._robots
                    else f"robot {message.robot}"
                )
                yield Violation(
                    invariant=NAME,
                    says=f"a message of {sender} at {message.time_s:.2f} s ({message.kind}) "
                    f"{wrong}",
                    robot=message.robot,
                    time_s=message.time_s,
                )

    def _wrong(self, message: Sent) -> str | None:
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

    def _works(self, member: int, time_s: float) -> bool:
        if member == self._robots:
            return True
        on_s, dead_s = self._run.present_s(member)
        if not on_s - ROUNDING_S <= time_s <= dead_s + ROUNDING_S:
            return False
        return not any(
            fault.time_s + ROUNDING_S < time_s < fault.time_s + fault.duration_s - ROUNDING_S
            for fault in self._silences
            if fault.robot == member
        )

    def _reached(self, sender: int, now_s: float) -> set[int]:
        """Return all that are connected to a sender."""
        base = [] if self._run.recording.spec.base is None else [self._robots]
        waiting = {n for n in (*self._run.robots, *base) if self._works(n, now_s)} - {sender}
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
        radio, apart_m = self._radio, math.dist(here, there)
        if apart_m > radio.reach_m + ROUNDING_M:
            return False
        if radio.walls == "pass":
            return True
        line, free = shapely.LineString([here, there]), self._run.walls.grown
        if shapely.covers(free, line):
            return True
        if radio.walls == "block":
            return False
        walls = len(shapely.get_parts(shapely.difference(line, free)))
        # 10 n log10(distance / range) + the loss of all walls <= 0.
        weaker = radio.wall_loss_db * walls / (10.0 * radio.path_loss_exponent)
        return bool(apart_m <= radio.reach_m * 10.0**-weaker + ROUNDING_M)
