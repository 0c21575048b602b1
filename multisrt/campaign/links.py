"""The radio links of a run, computed from its motions, its world and the spec of its radio."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.campaign.bodies import FloatArray
from multisrt.campaign.judged_run import ROUNDING_M, ROUNDING_S, JudgedRun, silences

Place = tuple[float, float]


class Links:
    """The links between the members of a team at some times: possible ones, or certain ones.

    Members are the robots and the base station, whose number follows theirs. A link is possible if
    it is at most 1e-6 m longer than the range, and if, where walls matter, its line lies in free
    space enlarged by 1e-6 m or crosses few enough walls. A link is certain if the same holds with
    all tolerances reversed.

    Parameters
    ----------
    run : JudgedRun
        The run.
    times_s : iterable of float
        The times at which links are asked for, in seconds.
    is_sure : bool, optional
        Whether only certain links count.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", robots=2, starts=[(1, 1), (3, 1)], seed=1, max_time_s=1.0)
    >>> links = Links(JudgedRun(recording=run.recording, environment=ms.environment("open")), [0.0])
    >>> links.reached(0, 0.0)
    {1}
    """

    def __init__(self, run: JudgedRun, times_s: Iterable[float], *, is_sure: bool = False) -> None:
        self._run = run
        self._slack = -1.0 if is_sure else 1.0
        self._radio = run.recording.spec.radio
        self._silences = [silences(run.recording.spec.faults, robot) for robot in run.robots]
        self._held: dict[tuple[Place, Place], bool] = {}
        self._places = self._places_at(times_s)

    @property
    def members(self) -> range:
        """The numbers of all that take part in the radio traffic."""
        return range(len(self._run.robots) + (self._run.recording.spec.base is not None))

    def works(self, member: int, time_s: float) -> bool:
        """Whether a member is switched on, alive and not silent."""
        if member == len(self._run.robots):
            return True
        slack_s = self._slack * ROUNDING_S
        on_s, dead_s = self._run.present_s(member)
        if not on_s - slack_s <= time_s <= dead_s + slack_s:
            return False
        return not any(
            begin_s + slack_s < time_s < end_s - slack_s
            for begin_s, end_s in self._silences[member]
        )

    def apart_m(self, one: int, other: int, time_s: float) -> float:
        """Return the distance between two members, in metres."""
        places = self._places[time_s]
        return math.dist(places[one], places[other])

    def linked(self, member: int, time_s: float) -> set[int]:
        """Return the members to which a member has a link; none if its radio does not work."""
        if not self.works(member, time_s):
            return set()
        others = {n for n in self.members if n != member and self.works(n, time_s)}
        if self._radio.reaches_everywhere:
            return others
        return {n for n in others if self._holds(member, n, time_s)}

    def reached(self, sender: int, time_s: float) -> set[int]:
        """Return the members that a message reaches: directly, or by relays if there are any."""
        found = self.linked(sender, time_s)
        if self._radio.reaches_everywhere or not self._radio.multi_hop:
            return found
        relays = sorted(found)
        while relays:
            heard = self.linked(relays.pop(), time_s) - found - {sender}
            found |= heard
            relays += sorted(heard)
        return found

    # Links of places ------------------------------------------------------------------------

    def _places_at(self, times_s: Iterable[float]) -> dict[float, FloatArray]:
        times = np.unique(np.array([*times_s], np.float64))
        places = [track.at(times)[:, :2] for track in self._run.tracks]
        base = self._run.recording.spec.base
        if base is not None:
            places.append(np.tile(base.place, (len(times), 1)))
        return dict(zip(times.tolist(), np.stack(places, axis=1), strict=True))

    def _holds(self, one: int, other: int, time_s: float) -> bool:
        places = self._places[time_s]
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
