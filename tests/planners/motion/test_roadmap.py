import math
from itertools import pairwise, permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse.csgraph import csgraph_from_dense, dijkstra

from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.planners.motion.roadmap import Roadmap

Graph = tuple[list[tuple[int, int]], set[tuple[int, int]]]


def roadmap(places: dict[str, tuple[float, float]], edges: str) -> Roadmap[str]:
    result: Roadmap[str] = Roadmap()
    for place, (x, y) in places.items():
        result.add(place, x, y)
    for edge in edges.split():
        result.connect(edge[0], edge[1])
    return result


# From a to d it is 3 m by way of b and c, and 4 m by way of g.
DETOUR = roadmap(
    {
        "a": (0.0, 0.0),
        "b": (0.0, 1.0),
        "c": (1.0, 1.0),
        "d": (1.0, 0.0),
        "e": (5.0, 0.0),
        "f": (6.0, 0.0),
        "g": (0.5, -math.sqrt(3.75)),
    },
    "ab bc cd ag gd ef",
)


def test_three_short_paths_beat_a_long_one():
    assert DETOUR.path("a", "d") == ["a", "b", "c", "d"]
    assert DETOUR.path("d", "a") == ["d", "c", "b", "a"]


def test_the_path_to_the_start_is_the_start():
    assert DETOUR.path("a", "a") == ["a"]
    assert DETOUR.path_to_nearest("a", lambda place: True) == ["a"]


def test_unreachable_places_have_no_path():
    assert DETOUR.path("a", "f") is None
    assert DETOUR.path_to_nearest("a", lambda place: False) is None


def test_the_nearest_of_several_places_is_found():
    assert DETOUR.path_to_nearest("a", lambda place: place in "cd") == ["a", "b", "c"]


def test_a_place_without_paths():
    lonely = roadmap({"p": (1.0, 2.0)}, "")
    assert lonely.path("p", "p") == ["p"]
    assert lonely.path_to_nearest("p", lambda place: place == "q") is None


def test_adding_a_known_place_keeps_its_paths_and_where_it_is():
    again = roadmap({"a": (0.0, 0.0), "b": (3.0, 4.0)}, "ab ba")
    again.add("a", 9.0, 9.0)
    assert again.lengths(["a"]) == {"a": 0.0, "b": 5.0}


def test_places_that_were_not_added_are_refused():
    with pytest.raises(KeyError, match="z"):
        DETOUR.connect("a", "z")
    with pytest.raises(KeyError, match="z"):
        DETOUR.path("z", "a")
    with pytest.raises(KeyError, match="z"):
        DETOUR.lengths(["z"])
    assert not DETOUR.joins("a", "z")
    assert DETOUR.joins("b", "a")


def test_ties_go_to_the_place_connected_first():
    tied = roadmap({"s": (0.0, 0.0), "a": (1.0, 0.0), "b": (0.0, 1.0)}, "sb sa")
    assert tied.path_to_nearest("s", lambda place: place != "s") == ["s", "b"]


def test_search_ends_at_the_first_wanted_place():
    line: Roadmap[int] = Roadmap()
    line.add(0, 0.0, 0.0)
    for place in range(1000):
        line.add(place + 1, place + 1.0, 0.0)
        line.connect(place, place + 1)
    asked = []

    def wanted(place: int) -> bool:
        asked.append(place)
        return place == 3

    line.path_to_nearest(0, wanted)
    assert asked == [0, 1, 2, 3]


def test_an_edge_is_asked_about_only_where_it_ends_a_shortest_path():
    places = range(10)
    complete: Roadmap[int] = Roadmap()
    for place in places:
        complete.add(place, math.cos(place), math.sin(place))
    for a in places:
        for b in range(a):
            complete.connect(a, b)
    asked = []

    def passable(a: int, b: int) -> bool:
        asked.append((a, b))
        return a != 0 or b != 1

    lengths = complete.lengths([0], passable)
    assert len(lengths) == 10
    assert len(asked) == 10  # the ways straight to all, and that around to place 1
    assert lengths[1] > math.dist((1.0, 0.0), (math.cos(1), math.sin(1)))


def graphs(most: int) -> st.SearchStrategy[Graph]:
    """Return draws of places in the plane, and pairs of them."""
    spot = st.tuples(st.integers(-9, 9), st.integers(-9, 9))
    return st.lists(spot, min_size=2, max_size=most, unique=True).flatmap(
        lambda places: st.tuples(
            st.just(places),
            st.sets(
                st.tuples(st.integers(0, len(places) - 1), st.integers(0, len(places) - 1)).filter(
                    lambda pair: pair[0] < pair[1]
                )
            ),
        )
    )


def joined(graph: Graph) -> tuple[Roadmap[int], FloatArray]:
    """Return a roadmap, and the lengths of its edges as a matrix, infinite where there is none."""
    places, edges = graph
    result: Roadmap[int] = Roadmap()
    lengths = np.full((len(places), len(places)), np.inf)
    for number, (x, y) in enumerate(places):
        result.add(number, x, y)
    for a, b in sorted(edges):
        result.connect(a, b)
        lengths[a, b] = lengths[b, a] = math.dist(places[a], places[b])
    return result, lengths


@given(graphs(7))
def test_paths_agree_with_scipy_and_exhaustive_search(graph):
    ours, lengths = joined(graph)
    n = len(lengths)
    theirs = dijkstra(csgraph_from_dense(lengths, null_value=np.inf), indices=[0])[0]
    for goal in range(1, n):
        path = ours.path(0, goal)
        shortest = min(
            sum(lengths[step] for step in pairwise((0, *middle, goal)))
            for count in range(n - 1)
            for middle in permutations([p for p in range(1, n) if p != goal], count)
        )
        assert theirs[goal] == pytest.approx(shortest)
        if path is None:
            assert shortest == math.inf
        else:
            assert path[0] == 0
            assert path[-1] == goal
            assert sum(lengths[step] for step in pairwise(path)) == pytest.approx(shortest)
    nearest = ours.path_to_nearest(0, lambda place: place % 2 == 1)
    odd = theirs[1::2]
    assert (nearest is None) == bool(np.isinf(odd).all())
    if nearest is not None:
        assert nearest[-1] % 2 == 1
        assert theirs[nearest[-1]] == pytest.approx(odd.min())


@given(graphs(13), st.data())
def test_lengths_are_those_of_scipy(graph, data):
    ours, lengths = joined(graph)
    n = len(lengths)
    starts = data.draw(st.sets(st.integers(0, n - 1), min_size=1, max_size=3))
    expected = dijkstra(csgraph_from_dense(lengths, null_value=np.inf), indices=[*starts])
    found = ours.lengths(starts)
    nearest = expected.min(axis=0)
    assert {*found} == {k for k in range(n) if nearest[k] < np.inf}
    assert all(found[k] == pytest.approx(nearest[k]) for k in found)
    assert [*found.values()] == sorted(found.values())


def test_lengths_of_the_ways_that_can_be_gone():
    line = roadmap({"a": (0.0, 0.0), "b": (1.0, 0.0), "c": (2.0, 0.0)}, "ab bc")
    assert line.lengths(["a"], lambda _, b: b != "c") == {"a": 0.0, "b": 1.0}
    assert line.lengths([]) == {}
