"""Pictures on axes of matplotlib."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
import shapely
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from multisrt.drawing.axes import _path, plot_steps
from multisrt.drawing.colours import OBSTACLE, ROBOT_COLOURS
from multisrt.drawing.svg import Pen
from multisrt.environments.environment import Environment
from multisrt.finished_run import Run
from multisrt.geometry.errors import InvalidInputError

RING = Environment.from_outline(
    "ring", shapely.box(0, 0, 10, 6), [shapely.box(4, 2, 6, 4)], starts=[(1.0, 1.0)]
)


@pytest.fixture
def ax():
    return Figure(figsize=(5, 3)).add_subplot()


def obstacles(ax):
    return next(p for p in ax.patches if to_hex(p.get_facecolor()) == OBSTACLE.fill)


def test_obstacles_are_filled_and_free_space_is_not(ax):
    RING.plot(ax)
    path = obstacles(ax).get_path()
    # Matplotlib fills where the rings around a point do not cancel out.
    rings = [ring for ring in path.to_polygons() if len(ring) > 2]
    turns = {
        place: sum(
            (1 if shapely.LinearRing(ring).is_ccw else -1)
            for ring in rings
            if shapely.Polygon(ring).contains(shapely.Point(place))
        )
        for place in [(5.0, 3.0), (2.0, 3.0), (-0.05, 3.0)]
    }
    assert turns == {(5.0, 3.0): 1, (2.0, 3.0): 0, (-0.05, 3.0): 1}


def test_given_axes_are_only_drawn_on(ax):
    before = plt.get_fignums()
    ax.set_title("mine")
    ax.set_xlabel("here")
    assert RING.plot(ax) is ax
    assert plt.get_fignums() == before
    assert (ax.get_title(), ax.get_xlabel(), ax.get_legend()) == ("mine", "here", None)
    assert ax.figure.legends == []
    assert ax.get_aspect() == 1.0
    x0, x1 = ax.get_xlim()
    assert x0 < 0.0
    assert x1 > 10.0


@pytest.mark.parametrize("ax", ["x", 1, plt])
def test_only_axes_are_drawn_on(ax):
    with pytest.raises(InvalidInputError, match="drawn on axes of matplotlib"):
        RING.plot(ax)
    with pytest.raises(InvalidInputError, match="drawn on axes of matplotlib"):
        plot_steps([0.0], [1.0], ax)


def test_limits_that_were_set_are_kept(ax):
    ax.set(xlim=(0.0, 3.0), ylim=(0.0, 3.0))
    RING.plot(ax)
    assert (ax.get_xlim(), ax.get_ylim()) == ((0.0, 3.0), (0.0, 3.0))


def test_a_figure_of_its_own_has_title_and_legend():
    made = RING.plot()
    try:
        assert made.get_title(loc="left").startswith("ring\n10 m x 6 m")
        labels = [text.get_text() for text in made.figure.legends[0].get_texts()]
        assert labels == ["free space", "obstacle", "suggested start"]
        made.figure.canvas.draw()
    finally:
        plt.close("all")


def test_the_colours_are_those_of_the_svg(one_node, ax):
    Run(one_node).plot(ax)
    assert ROBOT_COLOURS[0] in {to_hex(patch.get_edgecolor()) for patch in ax.patches}
    ax.figure.canvas.draw()


@pytest.mark.parametrize("marker", ["disc", "triangle", "pin", "arrow", "cross", "star"])
def test_paths_are_those_of_the_pen(marker):
    pen = Pen(origin=(20_000.0, 10_000.0), decimals=3)
    path = _path(pen.marker(marker, 20_003.0, 10_004.0, 0.5), pen.origin)
    box = path.get_extents()
    assert np.allclose([(box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2], [20_003, 10_004], atol=0.2)
    assert 0.8 < box.width < 1.6


def test_rings_that_share_a_corner_are_filled_evenly():
    rings = [[(0, 0), (8, 0), (8, 8), (0, 8)], [(0, 0), (4, 0), (0, 4)], [(0, 0), (1, 0), (0, 1)]]
    path = _path(Pen().rings(rings), (0.0, 0.0), is_even_odd=True)
    turns = [shapely.LinearRing(np.asarray(ring)).is_ccw for ring in path.to_polygons()]
    assert turns == [True, False, True]
