"""The radio: which robots a message reaches, and when.

A link between two robots holds in both directions or in none. It is limited by the distance, and,
as the spec says, blocked or weakened by walls. Each passage of the straight line between the two
through an obstacle counts as one wall, however thick it is; touching a corner or running along a
wall is not a passage, as for a line of sight.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.random import Generator as RandomGenerator

from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import BoolArray, IntArray
from multisrt.geometry.numerics.kernel import FloatArray, kernel
from multisrt.geometry.regions.edge_index import EdgeGrid, EdgeIndex
from multisrt.geometry.regions.line_of_sight import crossings, edges_across
from multisrt.robots.explorer import RadioSelf
from multisrt.spec import RadioSpec

TOUCH_M = 1e-9
"""Length of a passage up to which a line only touches an obstacle, in metres."""


class Radio:
    """Carries messages between robots.

    Parameters
    ----------
    spec : RadioSpec
        How messages travel.
    index : EdgeIndex
        The edges of the world.
    rng : numpy.random.Generator
        The stream from which losses and jitter are drawn.

    Attributes
    ----------
    reaches_everywhere : bool
        Whether messages reach all robots wherever these are.
    """

    def __init__(self, spec: RadioSpec, index: EdgeIndex, rng: RandomGenerator) -> None:
        self._spec = spec
        self._index = index
        self._rng = rng
        self._range_m = spec.reach_m
        self.reaches_everywhere = spec.reaches_everywhere

    def datasheet(self) -> RadioSelf:
        """Return what a robot knows of its radio."""
        return RadioSelf(
            range_m=self._range_m,
            latency_s=self._spec.latency_s + self._spec.jitter_s,
            loss=self._spec.loss,
            multi_hop=self._spec.multi_hop,
            reaches_all=self.reaches_everywhere and self._spec.loss == 0.0,
            walls_matter=self._spec.walls_matter,
        )

    def links(self, positions: Sequence[Sequence[float]], working: Sequence[bool]) -> BoolArray:
        """Return which robots reach each other without a relay.

        Parameters
        ----------
        positions : (n, 2) array_like
            Where the robots are, in metres.
        working : sequence of bool
            Whether the radio of each robot works.

        Returns
        -------
        (n, n) array of bool
            Symmetric, with False on the diagonal.
        """
        places = _places(positions)
        robots = np.flatnonzero(working)
        holds = np.zeros((len(places), len(places)), np.bool_)
        for i, robot in enumerate(robots):
            heard = self._heard(places, int(robot), robots[i + 1 :])
            holds[robot, heard] = holds[heard, robot] = True
        return holds

    def reached(
        self, sender: int, positions: Sequence[Sequence[float]], working: Sequence[bool]
    ) -> list[int]:
        """Return the robots that a message reaches, in increasing order.

        They are those to which the sender has a link and, where robots relay, all that are
        connected to it through others; none if the radio of the sender does not work.

        Parameters
        ----------
        sender : int
            The robot that sends.
        positions, working
            As for `links`; positions are not used if the radio reaches everywhere.
        """
        if not working[sender]:
            return []
        if self.reaches_everywhere:
            return [robot for robot, hears in enumerate(working) if hears and robot != sender]
        open_to = np.array(working, np.bool_)
        open_to[sender] = False
        places = _places(positions)
        found: list[int] = []
        relays = [sender]
        while relays and len(waiting := np.flatnonzero(open_to)):
            heard = self._heard(places, relays.pop(), waiting)
            open_to[heard] = False
            found += heard.tolist()
            if self._spec.multi_hop:
                relays += heard.tolist()
        return sorted(found)

    def deliveries(
        self,
        sender: int,
        to: int | None,
        positions: Sequence[Sequence[float]],
        working: Sequence[bool],
    ) -> tuple[list[tuple[int, float]], list[int]]:
        """Return to which robots a message is delivered, and to which it is lost.

        For each receiver in turn, the loss is drawn at random, and without a loss the delay.
        Neither is drawn where the spec leaves no choice.

        Parameters
        ----------
        sender : int
            The robot that sends.
        to : int or None
            The robot that the message is for; None for all.
        positions, working
            As for `reached`.

        Returns
        -------
        delivered : list of (int, float)
            Receivers in increasing order, each with the delay in seconds.
        lost : list of int
            Robots in reach to which the message is lost.
        """
        receivers = self.reached(sender, positions, working)
        if to is not None:
            receivers = [to] if to in receivers else []
        if self._spec.loss == 0.0 and self._spec.jitter_s == 0.0:
            return [(receiver, self._spec.latency_s) for receiver in receivers], []
        delivered: list[tuple[int, float]] = []
        lost: list[int] = []
        for receiver in receivers:
            if self._spec.loss > 0.0 and self._rng.random() < self._spec.loss:
                lost.append(receiver)
                continue
            delay = self._spec.latency_s
            if self._spec.jitter_s > 0.0:
                delay += self._spec.jitter_s * self._rng.random()
            delivered.append((receiver, delay))
        return delivered, lost

    def _heard(self, places: FloatArray, sender: int, others: IntArray) -> IntArray:
        # The others that have a link to the sender.
        distances = np.hypot(*(places[others] - places[sender]).T)
        others = others[distances <= self._range_m]
        if not self._spec.walls_matter or not len(others):
            return others
        ends = places[np.minimum(others, sender)], places[np.maximum(others, sender)]
        heard: IntArray = others[links_hold(self._spec, self._index, np.concatenate(ends, axis=1))]
        return heard


def links_hold(spec: RadioSpec, index: EdgeIndex | None, lines: FloatArray) -> BoolArray:
    """Return between which pairs of positions a link holds.

    Parameters
    ----------
    spec : RadioSpec
        How messages travel.
    index : EdgeIndex or None
        The edges of the world; may be None where walls do not matter.
    lines : (n, 4) array
        x, y of the two positions in metres; that of the robot with the lower number comes first,
        so that rounding is the same in both directions.

    Returns
    -------
    (n,) array of bool
    """
    distances = np.hypot(lines[:, 2] - lines[:, 0], lines[:, 3] - lines[:, 1])
    holds: BoolArray = distances <= spec.reach_m
    if not spec.walls_matter or not holds.any():
        return holds
    assert index is not None
    walls = _walls_between(index, lines[holds])
    if spec.walls == "block":
        holds[holds] = walls == 0
    else:
        holds[holds] = distances[holds] <= weakened_range(spec, walls)
    return holds


def weakened_range(spec: RadioSpec, walls: IntArray) -> FloatArray:
    """Return the range of a radio in metres through given numbers of walls that weaken it."""
    assert spec.range_m is not None
    # 10 n log10(distance / range) + wall loss <= 0, with n the exponent of the path loss.
    loss_db = spec.wall_loss_db * walls.astype(np.float64)
    decades = -loss_db / (10.0 * spec.path_loss_exponent)
    reach: FloatArray = spec.range_m * libm.power(10.0, decades)
    return reach


def _walls_between(index: EdgeIndex, lines: FloatArray) -> IntArray:
    return _walls_on(lines, index.grid)


def _places(positions: Sequence[Sequence[float]]) -> FloatArray:
    return np.array(positions, dtype=np.float64).reshape(-1, 2)


@kernel
def _walls_on(lines: FloatArray, grid: EdgeGrid) -> IntArray:
    walls = np.zeros(lines.shape[0], np.int64)
    for k in range(lines.shape[0]):
        ax, ay, bx, by = lines[k, 0], lines[k, 1], lines[k, 2], lines[k, 3]
        across = edges_across(ax, ay, bx, by, grid)
        if across.shape[0] > 0:
            walls[k] = _passages(lines[k], grid.edges, across)
    return walls


@kernel
def _passages(line: FloatArray, edges: FloatArray, across: IntArray) -> int:
    # The number of stretches of a line with obstacles on both of its sides. An obstacle that only
    # touches the line with a corner or a side lies on one side of it.
    ax, ay = line[0], line[1]
    length = np.hypot(line[2] - ax, line[3] - ay)
    ux, uy = (line[2] - ax) / length, (line[3] - ay) / length
    at, right, left = crossings(ax, ay, ux, uy, edges, across)
    beyond = (at <= 0.0) | (at >= length)
    right[beyond] = 0
    left[beyond] = 0
    passages = 0
    depth_right = depth_left = 0
    entered, left_behind = 0.0, -np.inf
    inside = False
    for k in np.argsort(at):
        depth_right += right[k]
        depth_left += left[k]
        if depth_right > 0 and depth_left > 0:
            if not inside:
                # Walls that meet on the line count as one.
                if at[k] - left_behind > TOUCH_M:
                    entered = at[k]
                inside = True
        elif inside:
            inside = False
            if at[k] - entered > TOUCH_M:
                if entered > left_behind:
                    passages += 1
                left_behind = at[k]
    return passages
