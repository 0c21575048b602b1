"""What tests of frontiers share: subtractions from segments."""

from types import SimpleNamespace

import numpy as np
import pytest

from multisrt.geometry.numerics.rings import Rings
from multisrt.geometry.regions.frontier_update import SHARED_BORDER_M
from multisrt.geometry.regions.segment_difference import beside, intersect_pieces, uncovered


@pytest.fixture(scope="session")
def subtracting():
    """The functions of this file."""
    return SimpleNamespace(take=take, remainder=remainder, along=along)


def take(segments, polygons, ids=None):
    """Return what the polygons leave of the segments."""
    if not polygons:
        return segments
    ids = np.arange(len(polygons)) if ids is None else np.asarray(ids, np.int64)
    rest, _ = uncovered(segments, Rings(polygons).arrays(ids), ids)
    return rest


def remainder(subtract, pieces, wholes):
    """Return what a subtraction from whole segments leaves of pieces of these."""
    left, origin = intersect_pieces(pieces, wholes, *subtract(wholes))
    return left, wholes[origin]


def along(lines):
    """Return the subtraction of what lies along lines."""
    return lambda wholes: beside(wholes, np.ones(len(wholes), bool), lines, SHARED_BORDER_M)
