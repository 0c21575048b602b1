"""What tests of collisions share: bodies, and where they are along a motion."""

from types import SimpleNamespace

import numpy as np
import pytest
import shapely

from multisrt.geometry.bodies.footprint import Footprint

FOOTPRINTS = {
    "disc": Footprint.disc(0.25),
    "box": Footprint.box(0.6, 0.4),
    "wedge": Footprint.parse("polygon:-0.2,-0.12 0.25,-0.12 0.32,0 0.25,0.12 -0.2,0.12"),
    "ell": Footprint.parse("polygon:-0.2,-0.2 0.6,-0.2 0.6,0.1 0.1,0.1 0.1,0.5 -0.2,0.5"),
    "bend": Footprint.parse(
        "polygon:-0.3,-0.4 0.5,-0.4 0.5,-0.2 0.1,-0.2 0.1,0.2 0.5,0.2 0.5,0.4 -0.3,0.4"
    ),
}


@pytest.fixture(scope="session")
def moving():
    """The functions of this file."""
    return SimpleNamespace(
        footprints=FOOTPRINTS,
        placed=placed,
        touches=touches,
        gaps=gaps,
        on_line=on_line,
        on_arc=on_arc,
        random_poses=random_poses,
    )


def placed(footprint, poses):
    """Return polygons of a body at ``(n, 3)`` poses and 0, or a disc's centres and radius."""
    poses = np.asarray(poses, dtype=float).reshape(-1, 3)
    if footprint.is_disc:
        return shapely.points(poses[:, :2]), footprint.radius_m
    c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
    px, py = footprint.vertices.T
    x = poses[:, :1] + c * px - s * py
    y = poses[:, 1:2] + s * px + c * py
    return shapely.polygons(np.stack([x, y], axis=-1)), 0.0


def touches(geometry, footprint, poses):
    """Whether a body at each pose touches a geometry."""
    places, radius = placed(footprint, poses)
    return shapely.dwithin(geometry, places, radius)


def gaps(footprint_a, poses_a, footprint_b, poses_b):
    """Return the distances of two bodies; for discs negative where they overlap."""
    places_a, radius_a = placed(footprint_a, poses_a)
    places_b, radius_b = placed(footprint_b, poses_b)
    return shapely.distance(places_a, places_b) - radius_a - radius_b


def on_line(start, turn, end, fractions):
    """Return the poses after fractions of a straight motion."""
    step = np.array([end[0] - start[0], end[1] - start[1], turn])
    return np.array(start) + fractions[:, None] * step


def on_arc(start, turn, end, fractions):
    """Return the poses after fractions of a motion on an arc, about its fixed point."""
    first, last = complex(*start[:2]), complex(*end[:2])
    centre = (last - first * np.exp(1j * turn)) / (1 - np.exp(1j * turn))
    points = centre + (first - centre) * np.exp(1j * turn * fractions)
    return np.column_stack([points.real, points.imag, start[2] + turn * fractions])


def random_poses(rng, count, low=-1.0, high=17.0):
    """Return random poses in a square."""
    return np.column_stack([rng.uniform(low, high, (count, 2)), rng.uniform(-4, 4, count)])
