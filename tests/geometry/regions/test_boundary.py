"""Arcs as chords, by hand."""

import math

import pytest

from multisrt.geometry.regions.boundary import arc_divisions


@pytest.mark.parametrize(
    ("radius", "tolerance", "divisions"), [(4.0, 0.01, 45), (1.0, 2.0, 8), (1.0, 0.5, 8)]
)
def test_arcs_have_as_many_chords_as_their_tolerance_needs(radius, tolerance, divisions):
    # A chord's middle is r (1 - cos(pi / n)) inside the arc.
    assert arc_divisions(radius, tolerance) == divisions
    if divisions > 8:
        assert radius * (1 - math.cos(math.pi / divisions)) <= tolerance
        assert radius * (1 - math.cos(math.pi / (divisions - 1))) > tolerance
