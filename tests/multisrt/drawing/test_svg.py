import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import msgspec
import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.drawing import environment_svg, tree_svg
from multisrt.drawing.svg import Pen, number, plain
from multisrt.environments.environment import Environment
from tests.multisrt.drawing.pictures import lines, texts


@pytest.mark.parametrize(
    "name",
    [
        "<b>&amp;\"'</b>]]>",
        "caf\u00e9 \u5730\u56f3 \U0001f916",
        "a\nb\tc",
        "\x00\x07\x1b",
        "\ud800",
        "",
        "x" * 5000,
    ],
)
def test_any_name_gives_valid_xml(name, one_node):
    header = msgspec.structs.replace(one_node.header, world=name)
    svg = tree_svg(replace(one_node, header=header))
    ET.fromstring(svg.encode())
    ET.fromstring(environment_svg(Environment(name, shapely.box(0, 0, 1, 1))).encode())


def test_special_letters_are_escaped_and_kept(one_node):
    header = msgspec.structs.replace(one_node.header, world="<R&D> \u5730\u56f3")
    svg = tree_svg(replace(one_node, header=header))
    assert texts(svg)[0] == "srt-radial in <R&D> \u5730\u56f3, seed 0"
    assert "&lt;R&amp;D&gt;" in svg


@given(st.integers(-(10**9), 10**9), st.integers(0, 6))
def test_numbers_are_exact(steps, decimals):
    assert float(number(steps, decimals)) == pytest.approx(steps / 10**decimals, rel=1e-15)


@given(st.floats(-1e9, 1e9).filter(lambda v: v == 0.0 or abs(v) > 1e-9))
def test_plain_numbers_have_no_exponent(value):
    assert re.fullmatch(r"-?\d*\.?\d+", plain(value))
    assert float(plain(value)) == pytest.approx(value, rel=1e-7)


@given(st.lists(st.tuples(st.floats(-50, 50), st.floats(-50, 50)), min_size=2, max_size=200))
def test_rounding_does_not_add_up_along_a_line(points):
    drawn = lines(Pen(decimals=2).line(points))[0]
    distances = shapely.distance(shapely.points(points), shapely.MultiPoint(drawn))
    assert distances.max() < 0.0071
    np.testing.assert_allclose(drawn[[0, -1]], np.asarray(points)[[0, -1]], atol=0.00501)


def test_rings_below_the_rounding_are_left_out():
    pen = Pen(decimals=1)
    assert pen.rings([[(0, 0), (0.01, 0), (0.01, 0.01), (0, 0)]]) == ""
    assert pen.rings([[(0, 0), (2, 0), (2, 1), (0, 0)]]) == "M0 0l2 0 0 1z"
