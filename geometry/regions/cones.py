"""The boundary of a star or a ball: equal cones, each cut at its smallest reading."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from multisrt.geometry.numerics.kernel import FloatArray, kernel
from multisrt.geometry.regions.boundary import (
    CUT,
    OBSTACLE,
    RANGE,
    Chain,
    TagArray,
    add_open_piece,
)

INWARD_M = 1e-6
"""A side between two cones runs along a wall that reaches at most this far into the larger cone,
in metres."""


class Cones(NamedTuple):
    """Equal cones around the place of a scan.

    Attributes
    ----------
    x, y : float
        The place in metres.
    reach : float
        Maximum depth of a cone in metres.
    number : int
        Number of cones; the first begins in direction +x.
    parts : int
        Number of chords that stand for the arc of a cone.
    """

    x: float
    y: float
    reach: float
    number: int
    parts: int


class _Walls(NamedTuple):
    # Surfaces (k, 4) relative to the place, counter-clockwise, and for each (k, 2) the angle at
    # which it begins, in [0, 2 pi], and the angle that it spans.
    ends: FloatArray
    spans: FloatArray


@kernel
def cut_at_smallest_readings(
    boundary: FloatArray, tags: TagArray, cones: Cones, contact_tolerance_m: float
) -> tuple[FloatArray, TagArray]:
    """Compute the boundary of a star, or of a ball, which is a star of one cone.

    Parameters
    ----------
    boundary : (n, 2) array
        Corners of the visible region in metres, counter-clockwise.
    tags : (n,) array of int8
        Tags of its boundary.
    cones : Cones
        The cones.
    contact_tolerance_m : float
        A star's boundary is obstacle where a surface lies at most this far behind it, in metres.

    Returns
    -------
    boundary : (m, 2) array
        Every cone's arc of chords; radial sides join cones of different depth.
    tags : (m,) array of int8
        `RANGE`, `OBSTACLE` or `CUT`.
    """
    depths, walls = _readings(boundary, tags, cones)
    opening = cones.parts * (2.0 * np.pi / (cones.number * cones.parts))
    most = cones.number * cones.parts + (cones.number + 1) * (2 + 4 * walls.ends.shape[0])
    chain = Chain(np.empty((most, 2)), np.empty(most, np.int8))
    placed = walls.ends + np.array([cones.x, cones.y, cones.x, cones.y])
    count = 0
    previous = depths[cones.number - 1]
    for cone in range(cones.number):
        depth = depths[cone]
        begin = cone * opening
        if abs(previous - depth) > 1e-9:
            ux, uy = np.cos(begin), np.sin(begin)
            count = add_open_piece(
                chain,
                count,
                (cones.x + previous * ux, cones.y + previous * uy),
                (cones.x + depth * ux, cones.y + depth * uy),
                placed,
                (contact_tolerance_m, INWARD_M),
                CUT,
            )
        previous = depth
        contacts = np.empty((0, 2))
        if depth < cones.reach:
            contacts = _contacts(walls, depth + contact_tolerance_m, begin, opening)
        count = _add_arc(cones, begin, depth, contacts, chain, count)
    return chain.corners[:count].copy(), chain.tags[:count].copy()


@kernel
def _readings(boundary: FloatArray, tags: TagArray, cones: Cones) -> tuple[FloatArray, _Walls]:
    # The smallest reading in every cone, and the surfaces.
    x, y = cones.x, cones.y
    opening = cones.parts * (2.0 * np.pi / (cones.number * cones.parts))
    depths = np.full(cones.number, cones.reach)
    corners = boundary.shape[0]
    walls = _Walls(np.empty((corners, 4)), np.empty((corners, 2)))
    wall_count = 0
    for i in range(corners):
        j = i + 1 if i + 1 < corners else 0
        ax, ay = boundary[i, 0] - x, boundary[i, 1] - y
        bx, by = boundary[j, 0] - x, boundary[j, 1] - y
        near_end = min(np.hypot(ax, ay), np.hypot(bx, by))
        if tags[i] == RANGE and near_end > cones.reach - 1e-6:
            continue
        if ax * by - ay * bx < 0.0:
            ax, ay, bx, by = bx, by, ax, ay
        dx, dy = bx - ax, by - ay
        length2 = dx * dx + dy * dy
        if length2 == 0.0:
            continue
        start = np.arctan2(ay, ax)
        end = np.arctan2(by, bx)
        if end < start - np.pi:
            end += 2.0 * np.pi
        closest = -(ax * dx + ay * dy) / length2
        first = int(np.floor((start - 1e-12) / opening))
        last = int(np.floor((end + 1e-12) / opening))
        for cone in range(first, last + 1):
            t0 = _crossing(ax, ay, dx, dy, start, end, cone * opening)
            t1 = _crossing(ax, ay, dx, dy, start, end, (cone + 1) * opening)
            t = min(max(closest, t0), max(t0, t1))
            k = cone % cones.number
            depths[k] = min(depths[k], np.hypot(ax + t * dx, ay + t * dy))
        if tags[i] == OBSTACLE:
            walls.ends[wall_count] = ax, ay, bx, by
            walls.spans[wall_count, 0] = start if start >= 0.0 else start + 2.0 * np.pi
            walls.spans[wall_count, 1] = end - start
            wall_count += 1
    return depths, _Walls(walls.ends[:wall_count], walls.spans[:wall_count])


@kernel
def _add_arc(
    cones: Cones, begin: float, depth: float, contacts: FloatArray, chain: Chain, count: int
) -> int:
    # Write the chords of a cone's arc, and corners where contacts with walls begin and end;
    # return the new number of corners.
    width = 2.0 * np.pi / (cones.number * cones.parts)
    angle, part = 0.0, 0
    while part < cones.parts:
        # The next corner of the chords, or border of a contact, whichever comes first.
        until = (part + 1) * width
        is_touching = False
        for k in range(contacts.shape[0]):
            low, high = contacts[k, 0], contacts[k, 1]
            if low <= angle + 1e-9:
                if high > angle + 1e-9:
                    is_touching = True
                    until = min(until, high)
            else:
                until = min(until, low)
        theta = begin + angle
        chain.corners[count, 0] = cones.x + depth * np.cos(theta)
        chain.corners[count, 1] = cones.y + depth * np.sin(theta)
        chain.tags[count] = RANGE if depth == cones.reach else (OBSTACLE if is_touching else CUT)
        count += 1
        angle = until
        if angle >= (part + 1) * width - 1e-9:
            part += 1
            angle = part * width
    return count


@kernel
def _contacts(walls: _Walls, radius: float, begin: float, opening: float) -> FloatArray:
    # Between which angles from `begin`, over one cone, walls lie within a radius.
    spans = walls.spans
    contacts = np.empty((spans.shape[0] + 1, 2))
    count = 0
    for k in range(spans.shape[0]):
        first = (spans[k, 0] - begin) % (2.0 * np.pi)
        if first > opening and first + spans[k, 1] < 2.0 * np.pi:
            continue
        ax, ay = walls.ends[k, 0], walls.ends[k, 1]
        dx, dy = walls.ends[k, 2] - ax, walls.ends[k, 3] - ay
        length2 = dx * dx + dy * dy
        cross = ax * dy - ay * dx
        chord2 = radius * radius - cross * cross / length2
        if chord2 <= 0.0:
            continue
        middle, half = -(ax * dx + ay * dy) / length2, math.sqrt(chord2 / length2)
        t0, t1 = max(0.0, middle - half), min(1.0, middle + half)
        if t1 <= t0:
            continue
        # Angles relative to the wall's own begin never wrap: a wall spans less than pi.
        low = _angle_between(ax, ay, ax + t0 * dx, ay + t0 * dy)
        high = _angle_between(ax, ay, ax + t1 * dx, ay + t1 * dy)
        if first > opening:
            first -= 2.0 * np.pi
        low, high = max(0.0, first + low), min(opening, first + high)
        if high > low:
            contacts[count, 0], contacts[count, 1] = low, high
            count += 1
    return contacts[:count]


@kernel
def _angle_between(ax: float, ay: float, bx: float, by: float) -> float:
    return math.atan2(ax * by - ay * bx, ax * bx + ay * by)


@kernel
def _crossing(
    ax: float, ay: float, dx: float, dy: float, start: float, end: float, theta: float
) -> float:
    # Where the ray in direction theta meets the segment from a, seen from angle start to end,
    # as a share of the segment's length; its nearer end for rays that pass beside it.
    if theta <= start:
        return 0.0
    if theta >= end:
        return 1.0
    ux, uy = math.cos(theta), math.sin(theta)
    return min(1.0, max(0.0, (ax * uy - ay * ux) / (ux * dy - uy * dx)))
