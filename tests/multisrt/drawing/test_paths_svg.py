import numpy as np

from multisrt.drawing import tree_svg
from tests.multisrt.drawing.pictures import SVG, layers, lines, paths, texts
from tests.multisrt.drawing.recordings import A, B, C, D, E, F


def test_nodes_in_the_tree_of_another_hang_there(support):
    svg = tree_svg(support)
    own, other = layers(svg)["robot 0: tree"].findall(SVG + "path")
    assert [own.get("id"), other.get("id")] == [
        "robot-0-edges-in-tree-0",
        "robot-0-edges-in-tree-1",
    ]
    np.testing.assert_allclose(lines(own.get("d", "")), [(A, B)])
    np.testing.assert_allclose(lines(other.get("d", "")), [(E, F)])
    np.testing.assert_allclose(lines(paths(layers(svg)["robot 1: tree"])), [(C, D), (D, E)])
    assert "0: 3 nodes, 23 m" in texts(svg)
    assert "1: 3 nodes, 16 m" in texts(svg)


def test_bridges_are_paths_between_nodes_without_an_edge(support):
    svg = tree_svg(support)
    np.testing.assert_allclose(lines(paths(layers(svg)["robot 0: bridges"])), [(B, E)])
    assert "robot 1: bridges" not in layers(svg)
    assert "bridge between two nodes" in texts(svg)
    assert "path off the tree" not in texts(svg)


def test_moves_to_support_others_are_dashed_and_drawn_once(support):
    found = layers(tree_svg(support))
    (line,) = lines(paths(found["robot 0: supporting moves"]))
    np.testing.assert_allclose(line, [A, B, E, F])
    assert found["robot 0: supporting moves"].get("stroke-dasharray")
    assert "robot 1: supporting moves" not in found
